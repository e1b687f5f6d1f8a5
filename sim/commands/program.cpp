#include <CLI/CLI.hpp>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include "common/command_line/command_line.hpp"
#include "common/messages/channels.hpp"
#include "common/wire/lcm_url.hpp"
#include "sim/commands/commands.hpp"
#include "sim/gev/gev_camera.hpp"
#include "sim/gpiochip/chip.hpp"

namespace strobe::sim {

namespace {

void add_scene(CLI::App& command, std::string& scene) {
  command.add_option("--scene", scene, "Scene's name (see `strobe-sim scenes`) or a scene file")->required();
}

void add_shots(CLI::App& command, SimulatedOptions& options) {
  add_scene(command, options.scene);
  command.add_option("--shots", options.shots, "How many")->capture_default_str();
  command.add_option("--seed", options.seed, "Seed of every random draw")->capture_default_str();
}

void add_train(CLI::App& command, SimulatedOptions& options) {
  command.add_option("--period-ms", options.period_ms, "Between flashes")->capture_default_str();
  command.add_option("--exposure-ms", options.exposure_ms,
                     "Length of the train of flashes (0: while balls cross the view)");
}

void add_run(CLI::App& app, RunOptions& options, bool& no_digitizer) {
  CLI::App* run = app.add_subcommand("run", "Run a command on a simulated rig");
  run->footer(
      "The command sees the rig's chip as /dev/gpiochip0 (or the scene's name for it). Its exit status is "
      "passed on, 128 plus the signal if one ended it. A folder given by --chip-dir holds the chip until "
      "strobe-sim ends, so that `strobe-sim lines`, `drive` and `unplug` can be used on it meanwhile.\n"
      "Example: strobe-sim run --scene zero_23 --photographs photos --write-rig rig.toml -- \\\n"
      "           strobed --config rig.toml --session today --allow-no-rt");
  add_scene(*run, options.scene);
  run->add_option("--seed", options.seed, "Seed of every random draw (default: a fresh one, printed)");
  run->add_option("--lcm-url", options.lcm_url, "LCM URL of the tablet")
      ->capture_default_str()
      ->check(wire::lcm_url_problem);
  run->add_option("--key-file", options.key_file,
                  "the lab's key, for the tablet's operator (default: $STROBE_KEY_FILE, "
                  "~/.config/strobe/lab.key)");
  run->add_option("--rig", options.rig_name, "Rig's name in the LCM channels")->capture_default_str();
  run->add_option("--chip-dir", options.chip_dir, "Folder for the chip (default: a temporary one)")
      ->envname(kChipDirVariable);
  run->add_option("--truth", options.truth_file, "Write what truly happened, one JSON object per shot");
  run->add_option("--changes", options.changes_file, "Write every change of every line as CSV");
  run->add_option("--photographs", options.photographs,
                  "Folder for a photograph of each exposure; no tablet operator then");
  auto* const camera = run->add_option_function<std::string>(
      "--camera",
      [&options](const std::string& kind) {
        options.gev_camera = kind == "gev";
        options.ptp_camera = kind == "ptp";
      },
      "On the loopback: GigE Vision or PTP/IP; no tablet operator then");
  camera->check(CLI::IsMember({"folder", "gev", "ptp"}))->default_str("folder");
  run->add_option("--camera-address", options.camera_address, "IPv4 address of that camera, 127.x.y.z")
      ->check(gev::address_problem)
      ->capture_default_str();
  run->add_flag("--sequencer", options.sequencer,
                "The lines are on a flash sequencer, at the terminal `sequencer` in --chip-dir");
  run->add_option(
      "--write-rig", options.rig_file,
      "Write a rig file that fits the scene, for strobed --config and strobe fire --rig; a file that "
      "says something else is not overwritten");
  run->add_option("--time", options.pace,
                  "wall: the computer's clock, but it waits for the programs, so that a busy computer makes "
                  "nothing late; fast: waits for the programs only, never for the clock; real: the "
                  "computer's clock, to judge how prompt they are")
      ->transform(CLI::CheckedTransformer(std::map<std::string, gpio::Pace>{
          {"wall", gpio::Pace::wall}, {"fast", gpio::Pace::fast}, {"real", gpio::Pace::machine}}))
      ->default_str("wall");
  run->add_option(
         "--clock-start", options.clock_start_s,
         "For a run that repeats to the byte, with --time fast and --seed: where the programs' monotonic "
         "clock "
         "starts, in seconds, and their wall clock as long after 2000-01-01; what they draw is fixed, too")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1'000'000'000}));
  run->add_option("--tolerance", options.tolerance,
                  "Leave out effects that change no number read by more than this: 0.5%, 5e-3");
  run->add_flag("--no-digitizer", no_digitizer, "Photographs are not digitized; no LCM is needed");
  run->add_option("command", options.command,
                  "Command and its arguments, after --; may be left out with --write-rig");
  command_line::for_experts(*run, {"--lcm-url", "--key-file", "--rig", "--changes", "--tolerance",
                                   "--no-digitizer", "--camera-address", "--sequencer"});
}

void add_shoot(CLI::App& app, ShootOptions& options, bool& as_json) {
  CLI::App* shoot = app.add_subcommand("shoot", "Simulate whole shots in virtual time, without a firmware");
  shoot->footer(
      "Prints one frame per line, always as JSON, for `strobe reduce --format frame`. The same scene, seed, "
      "model and settings print the same bytes. A model is \"full\", \"none\", the effects to have "
      "(gravity,grip) or those to leave out (--model=-pixels,-drag).\n\n"
      "Example: strobe-sim shoot --scene zero_23 --shots 9 --seed 42 | strobe reduce - --format frame");
  add_shots(*shoot, options);
  auto* model = shoot->add_option("--model", options.model, "Effects to simulate")->capture_default_str();
  shoot
      ->add_option("--tolerance", options.tolerance,
                   "Leave out effects that change no number read by more than this: 0.5%, 5e-3 (see effects)")
      ->excludes(model);
  add_train(*shoot, options);
  shoot->add_flag("--perfect", options.perfect_digitizer, "Digitize without error, though stating one");
  shoot->add_option("--truth", options.truth_file, "Write what truly happened, one JSON object per shot");
  shoot->add_flag("--json", as_json, "As for other commands; frames are JSON anyway");
}

void add_photograph(CLI::App& app, PhotographOptions& options) {
  CLI::App* photograph = app.add_subcommand("photograph", "Render photographs of simulated shots");
  photograph->footer(
      "Writes shot_0001.tif ... into the folder, as the scene's [photograph], [ball_appearance] and "
      "[background] say, and truth.jsonl: one JSON object per photograph with what a perfect measurement "
      "would "
      "read. The same scene, seed and settings write the same photographs.\n\n"
      "Example: strobe-sim photograph --scene zero_23 --shots 3 --seed 42 --out photographs");
  add_shots(*photograph, options);
  photograph->add_option("--out", options.folder, "Folder for the photographs, made if missing")->required();
  photograph
      ->add_option("--format", options.format,
                   "tiff, png, dng (a colour camera's RAW file) or mosaic (its numbers as TIFF), in place of "
                   "the scene's")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, PhotographFormat>{{"tiff", PhotographFormat::tiff},
                                                  {"png", PhotographFormat::png},
                                                  {"dng", PhotographFormat::dng},
                                                  {"mosaic", PhotographFormat::mosaic}}));
  add_train(*photograph, options);
  photograph->add_flag("--json", options.json, "Print the lines of truth instead of the files' names");
}

void add_board(CLI::App& app, BoardOptions& o) {
  CLI::App* board = app.add_subcommand("board", "Render photographs of a calibration board");
  board->footer(
      "Writes plane.tif, slanted_1.tif ... for `strobe calibrate`, and truth.jsonl: one JSON object per "
      "photograph with camera, place and where each point of the board truly is.\n\n"
      "Example: strobe-sim board --spacing-mm 25 --lens -0.2 0.1 0 0 --slanted 4 --out boards");
  board->add_option("--out", o.folder, "Folder for the photographs, made if missing")->required();
  board->add_option(
      "--scene", o.scene,
      "Whose camera sees the board, in the balls' plane: a name or a file; otherwise the camera is "
      "given by options");
  board->add_option("--board", o.board, "What is printed")
      ->check(CLI::IsMember({"chessboard", "circles", "staggered"}))
      ->capture_default_str();
  board->add_option("--columns", o.columns, "Inner corners, or discs, along a row")
      ->check(CLI::Range(3, 100))
      ->capture_default_str();
  board->add_option("--rows", o.rows, "Rows of them")->check(CLI::Range(3, 100))->capture_default_str();
  board->add_option("--spacing-mm", o.spacing_mm, "Side of a square, or distance of discs")
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  board->add_option("--width-px", o.width_px, "Of the photograph")
      ->check(CLI::Range(64, 12000))
      ->capture_default_str();
  board->add_option("--height-px", o.height_px, "Of the photograph")
      ->check(CLI::Range(64, 12000))
      ->capture_default_str();
  board->add_option("--focal-px", o.focal_px, "The lens' focal length")
      ->check(CLI::Range(10.0, 1e6))
      ->capture_default_str();
  board->add_option("--lens", o.lens, "Its distortion, k1 k2 p1 p2 as in OpenCV")
      ->expected(4)
      ->check(CLI::Range(-1.0, 1.0))
      ->capture_default_str();
  board->add_option("--distance-m", o.distance_m, "Lens to the board's middle")
      ->check(CLI::Range(0.01, 1000.0))
      ->capture_default_str();
  board->add_option("--slanted", o.slanted, "More photographs, with the board slanted by 25 degrees")
      ->check(CLI::Range(0, 20))
      ->capture_default_str();
  board->add_option("--seed", o.seed, "Seed of the noise")->capture_default_str();
  command_line::for_experts(*board,
                            {"--width-px", "--height-px", "--focal-px", "--lens", "--distance-m", "--seed"});
  board->add_flag("--json", o.json, "Print the lines of truth instead of the files' names");
}

void add_effects(CLI::App& app, EffectsOptions& options) {
  CLI::App* effects = app.add_subcommand("effects", "Show which effects a scene requires at a tolerance");
  effects->footer(
      "For each effect: by how much leaving it out changes any number read from 500 sampled shots, at most. "
      "Left out is what costs a shot much and changes no number of a sampled shot by more than half of the "
      "tolerance, all of it together. A tolerance of 1% is 1 % of "
      "the speed for velocities, of v/R for spins, of a radian for angles, .01 for e and mu, 1 % of the "
      "dwell time, 1 for the court pace; a scene's [readout] may say otherwise.\n\n"
      "Example: strobe-sim effects --scene top_23 --tolerance 1%");
  add_scene(*effects, options.scene);
  effects->add_option("--tolerance", options.tolerance, "0.5%, 5e-3 (default: the scene's own)");
  add_train(*effects, options);
  effects->add_flag("--json", options.json, "One JSON object per effect, and one for all");
}

}  // namespace

int run_program(int argc, char** argv) {
  CLI::App app(
      "Simulated strobe rig: a GPIO chip with lamps, shutter, pitching machine, ball and camera behind it.");
  app.name("strobe-sim");
  command_line::set_help(app);
  app.set_version_flag("--version", STROBE_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Example: strobe-sim run --scene zero_23 --write-rig rig.toml -- strobed --config rig.toml --session "
      "today\n"
      "Exit status: 0 done, 1 ran but failed, 2 bad usage or input; of `run` its command's.");

  RunOptions options;
  options.camera_address = gev::kDefaultAddress;
  options.lcm_url = messages::kDefaultLcmUrl;
  bool no_digitizer = false;
  add_run(app, options, no_digitizer);

  bool as_json = false;
  CLI::App* scenes = app.add_subcommand("scenes", "List the scenes that come with the program");
  scenes->footer(
      "With what each inherits from. Broken ones are named on stderr, and the exit status is then 1.\n\n"
      "Example: strobe-sim scenes --json");
  scenes->add_flag("--json", as_json, "One JSON object per line");

  ShootOptions shots;
  add_shoot(app, shots, as_json);

  EffectsOptions effects;
  add_effects(app, effects);

  PhotographOptions photographs;
  add_photograph(app, photographs);

  BoardOptions boards;
  add_board(app, boards);

  // One for each: CLI11 gives $STROBE_GPIOCHIP_DIR to those, too, that are not on the command line.
  std::map<std::string, std::string> chip_dirs;
  std::string after;
  std::vector<std::string> words;
  const auto at_rig = [&app, &chip_dirs](const char* name, const char* what, const char* footer) {
    CLI::App* command = app.add_subcommand(name, what);
    command->footer(footer);
    command->add_option("--chip-dir", chip_dirs[name], "The chip's folder")
        ->envname(kChipDirVariable)
        ->required();
    return command;
  };
  const auto takes_command = [&words](CLI::App* command) {
    command->add_option("command", words, "Command and its arguments, after --")->required();
  };
  const auto may_wait = [&after](CLI::App* command) {
    command->add_option("--after", after, "LINE=N: at the line's Nth rise from now (default: at once)");
  };

  CLI::App* lines = at_rig(
      "lines", "Show each line of a running rig's chip",
      "Prints offset, name, direction, level and consumer.\nExample: strobe-sim lines --chip-dir /tmp/chip");
  lines->add_flag("--json", as_json, "One JSON object per line");

  CLI::App* drive = at_rig(
      "drive", "Drive inputs of a running rig's chip by hand",
      "Levels are physical: ESTOP=0 presses the e-stop. LINE=open breaks the line's wire until it is driven "
      "again: the chip's own resistor then decides, as strobed asked for it.\n"
      "Example: strobe-sim drive --chip-dir /tmp/chip KEY=0\n"
      "         strobe-sim drive --chip-dir /tmp/chip --after STROBE_A=20 ESTOP=0");
  drive->add_option("drives", words, "LINE=LEVEL, a line's name or offset and 0, 1 or open")->required();
  may_wait(drive);

  CLI::App* obey = at_rig(
      "operator", "Do at a running rig what strobe commission asks a person for",
      "Turns the key, presses the e-stop and pulls their wires when the command's standard error asks for "
      "it. Whatever else a person would have to judge is left to --yes.\n"
      "Example: strobe-sim operator --chip-dir /tmp/chip -- strobe commission --rig rig.toml --yes");
  takes_command(obey);

  CLI::App* join = at_rig(
      "join", "Run a command in the time of a running rig",
      "Time waits for it as for strobed: a host that joins loses nothing on a busy machine.\n"
      "Example: strobe-sim join --chip-dir /tmp/chip -- strobe fire --shots 3 --rig rig.toml --session "
      "today");
  takes_command(join);

  CLI::App* unplug = at_rig(
      "unplug", "Unplug a running rig's chip",
      "Every further call on it answers \"no such device\", and event lines hang up. A chip that keeps "
      "released outputs goes on driving them; one that does not lets them all go.\n"
      "Example: strobe-sim unplug --chip-dir /tmp/chip --after STROBE_A=20");
  may_wait(unplug);

  ClockOptions clocks;
  CLI::App* clock = at_rig(
      "clock", "Suspend the machine of a running rig, or set its wall clock",
      "For all programs in the rig's time. While the machine is suspended CLOCK_MONOTONIC stands still.\n"
      "Example: strobe-sim clock --chip-dir /tmp/chip --suspend 600\n"
      "         strobe-sim clock --chip-dir /tmp/chip --step -3600 --after STROBE_A=20");
  clock->add_option("--suspend", clocks.suspend_s, "CLOCK_BOOTTIME and CLOCK_REALTIME go on by as much [s]")
      ->check(CLI::Range(0.0, kLongestSuspension_s));
  clock->add_option("--step", clocks.step_s, "CLOCK_REALTIME is set by as much, back below 0 [s]")
      ->check(CLI::Range(-kLongestSuspension_s, kLongestSuspension_s));
  may_wait(clock);

  std::string tables;
  std::string folder;
  CLI::App* fit = app.add_subcommand("fit", "Derive the scenes of the thesis's conditions from its tables");
  fit->footer("Example: strobe-sim fit --tables share/strobe/thesis --out scenes");
  fit->add_option("--tables", tables, "Folder of tables_02_to_10.csv and corrections.csv")->required();
  fit->add_option("--out", folder, "Folder for the scene files")->required();
  fit->add_flag("--json", as_json, "One JSON object per line");

  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& shown) {  // help, or the version
    return app.exit(shown);
  } catch (const CLI::ParseError& error) {
    std::cerr << command_line::complaint(app, error) << '\n';
    return 2;
  }
  options.digitizer = !no_digitizer;
  if (scenes->parsed()) return scenes_command(as_json);
  if (app.got_subcommand("shoot")) return shoot_command(shots);
  if (app.got_subcommand("effects")) return effects_command(effects);
  if (app.got_subcommand("photograph")) return photograph_command(photographs);
  if (app.got_subcommand("board")) return board_command(boards);
  if (lines->parsed()) return lines_command(chip_dirs["lines"], as_json);
  if (drive->parsed()) return drive_command(chip_dirs["drive"], words, after);
  if (join->parsed()) return join_command(chip_dirs["join"], words);
  if (obey->parsed()) return operator_command(chip_dirs["operator"], words);
  if (clock->parsed()) return clock_command(chip_dirs["clock"], clocks, after);
  if (unplug->parsed()) return unplug_command(chip_dirs["unplug"], after);
  if (fit->parsed()) return fit_command(tables, folder, as_json);
  return run_command(options);
}

}  // namespace strobe::sim
