// Corrections of a photograph: what they are, their steps, their text, and the questions that they make.
import assert from "node:assert/strict";
import { test } from "node:test";

import { createModel, createUndo, withJudgement } from "../../../host/web/page/edit/model.js";
import { createNewestOnly } from "../../../host/web/page/edit/host.js";
import { correctionsText, editsFromList } from "../../../host/web/page/edit/state.js";
import * as state from "../../../host/web/page/edit/state.js";
import { changeWords, comparisonRows, verdictWords } from "../../../host/web/page/edit/controls.js";
import { createTool, dragged, handlesOf } from "../../../host/web/page/edit/tool.js";

const found = {
  images: [
    {
      centre_px: [100, 200],
      diameter_px: 60,
      equator_rad: 0.5,
      equator_sd_rad: 0.01,
      flash_index: 0,
      leg: "incoming",
      source: "auto",
    },
    {
      centre_px: [140.25, 230.5],
      diameter_px: 62,
      equator_rad: null,
      flash_index: 1,
      leg: "incoming",
      source: "auto",
    },
    {
      centre_px: [180, 200],
      diameter_px: 61,
      equator_rad: 1,
      flash_index: 2,
      leg: "rebound",
      source: "auto",
    },
  ],
  surface_px: [
    [0, 300],
    [400, 304],
  ],
};
const photo = { width: 400, height: 400 };
const modelOf = (changed = () => {}) => createModel({ found, photo, changed });

test("the text says what was done to each image, in px of the photograph, in the form that --edit reads", () => {
  let edits = state.remove(state.noEdits, "found-2");
  edits = state.measure(edits, "found-0", { centre: [101.23456, 199], diameter_px: 60.5, equator_deg: -30 });
  edits = state.measure(edits, "found-1", { no_equator: true, leg: "contact" });
  edits = state.add(edits, [250, 120.5], 61).edits;
  edits = state.setSurface(edits, [
    [10, 301],
    [390, 303.5],
  ]);
  assert.equal(
    correctionsText(found, edits),
    `[[remove]]
at_image_px = [180.0, 200.0]

[[move]]
at_image_px = [100.0, 200.0]
centre_image_px = [101.235, 199.0]
diameter_image_px = 60.5
equator_image_deg = -30.0

[[move]]
at_image_px = [140.25, 230.5]
no_equator = true
leg = "contact"

[[add]]
centre_image_px = [250.0, 120.5]
diameter_image_px = 61.0

[surface]
left_image_px = [10.0, 301.0]
right_image_px = [390.0, 303.5]
`,
  );
  assert.equal(correctionsText(found, state.noEdits), "");
});

test("an equator that was turned round and round is within what the file takes", () => {
  const text = correctionsText(found, state.measure(state.noEdits, "found-0", { equator_deg: 750 }));
  assert.match(text, /equator_image_deg = 30\.0\n/);
});

test("the host's list of corrections becomes edits, and those again the same text", () => {
  const list = [
    { kind: "remove", at_px: [181, 202] },
    {
      kind: "move",
      at_px: [99, 201],
      centre_px: [102, 200],
      centre_sd_px: 0.2,
      top_px: [102, 170],
      time_s: 0.0031,
    },
    { kind: "add", centre_px: [300, 100], diameter_px: 60, contact_width_px: 12 },
    { kind: "surface", left_px: [0, 300], right_px: [400, 300], sd_px: 0.5 },
  ];
  const { edits, lost } = editsFromList(found, list);
  assert.deepEqual(lost, []);
  assert.deepEqual(edits.removed, [2]);
  assert.deepEqual(edits.changed, {
    0: { centre: [102, 200], centre_sd_px: 0.2, top: [102, 170], time_s: 0.0031 },
  });
  const text = correctionsText(found, edits);
  for (const line of [
    "centre_sd_px = 0.2",
    "top_image_px = [102.0, 170.0]",
    "time_s = 0.0031",
    "contact_width_px = 12.0",
    "sd_px = 0.5",
  ])
    assert.ok(text.split("\n").includes(line), line);
});

test("corrections of an image that is no longer found are told as lost", () => {
  const { edits, lost } = editsFromList(found, [{ kind: "move", at_px: [390, 390], centre_px: [391, 390] }]);
  assert.deepEqual(edits, state.noEdits);
  assert.deepEqual(lost, [{ kind: "move", at: [390, 390] }]);
});

test("an sd goes with the number that it belongs to, and no equator excludes an angle", () => {
  let edits = state.measure(state.noEdits, "found-0", { equator_deg: 20 });
  edits = state.measure(edits, "found-0", { equator_sd_deg: 0.5 });
  assert.deepEqual(state.measuredOf(edits, "found-0"), { equator_deg: 20, equator_sd_deg: 0.5 });
  edits = state.measure(edits, "found-0", { no_equator: true });
  assert.deepEqual(state.measuredOf(edits, "found-0"), { no_equator: true });
  edits = state.measure(edits, "found-0", { equator_deg: 10 });
  assert.deepEqual(state.measuredOf(edits, "found-0"), { equator_deg: 10 });
  edits = state.measure(edits, "found-0", { equator_deg: null });
  assert.deepEqual(edits, state.noEdits);
});

test("edits never change: what was is still there", () => {
  const before = state.measure(state.noEdits, "found-0", { centre: [1, 2] });
  const copy = structuredClone(before);
  state.remove(before, "found-0");
  state.add(before, [5, 5], 10);
  state.restore(before, "found-0");
  assert.deepEqual(before, copy);
});

test("a removed image that is put back is as it was found", () => {
  const edits = state.remove(state.measure(state.noEdits, "found-1", { centre: [1, 2] }), "found-1");
  assert.equal(state.itemsOf(found, edits)[1].status, "removed");
  assert.deepEqual(state.itemsOf(found, state.restore(edits, "found-1"))[1], {
    key: "found-1",
    image: found.images[1],
    status: "found",
  });
});

test("steps go back and forth; a new one after going back drops what was ahead", () => {
  const undo = createUndo(0);
  undo.push(1, "one");
  undo.push(2, "two");
  assert.equal(undo.undo(), "two");
  assert.equal(undo.state(), 1);
  assert.equal(undo.redo(), "two");
  assert.equal(undo.state(), 2);
  undo.undo();
  undo.push(3, "three");
  assert.ok(!undo.canRedo());
  assert.equal(undo.undo(), "three");
  assert.equal(undo.undo(), "one");
  assert.equal(undo.state(), 0);
  assert.equal(undo.undo(), null);
});

test("a key that is held makes one step with its first press, and the next press another", () => {
  const undo = createUndo(0);
  undo.push(1, "move");
  undo.push(2, "move", true);
  undo.push(3, "move", true);
  undo.push(4, "move");
  undo.push(5, "turn", true);
  undo.undo();
  assert.equal(undo.state(), 4);
  undo.undo();
  assert.equal(undo.state(), 3);
  undo.undo();
  assert.equal(undo.state(), 0);
});

test("a drag is seen at once, is one step when it ends, and none when it is given up", () => {
  let changes = 0;
  const model = modelOf(() => {
    changes += 1;
  });
  model.select("found-0");
  model.attempt({ centre: [110, 200] });
  model.attempt({ centre: [120, 200] });
  assert.deepEqual(model.selectedItem().image.centre_px, [120, 200]);
  assert.equal(model.text(), "");
  model.dropAttempt();
  assert.deepEqual(model.selectedItem().image.centre_px, [100, 200]);
  model.attempt({ centre: [130, 200] });
  model.keepAttempt("move");
  assert.match(model.text(), /centre_image_px = \[130\.0, 200\.0\]/);
  assert.equal(model.undo(), "Undone: move image of flash 1, incoming");
  assert.equal(model.text(), "");
  assert.ok(changes >= 6);
});

test("an added image has the others' usual diameter, is chosen, and is gone when it is removed", () => {
  const model = modelOf();
  const key = model.add([300, 50]);
  assert.equal(model.selectedItem().key, key);
  assert.equal(model.selectedItem().image.diameter_px, 61);
  model.remove();
  assert.equal(model.selectedItem(), null);
  assert.equal(model.text(), "");
});

test("the surface line's ends are offered on the photograph and set the line", () => {
  const model = modelOf();
  model.chooseSurface();
  const [left, right] = model.surfaceEnds();
  for (const [column, row] of [left, right]) {
    assert.ok(column > 0 && column < 400);
    assert.ok(Math.abs(row - (300 + column / 100)) < 1e-6);
  }
  assert.deepEqual(Object.keys(handlesOf(model)), ["surface-0", "surface-1"]);
  model.attemptSurface([left, [right[0], 310]]);
  model.keepAttempt("move the surface line");
  assert.match(model.text(), /^\[surface\]\nleft_image_px/);
  model.undo();
  assert.equal(model.text(), "");
});

test("the rim's handle sets the diameter, the equator's its angle, the middle's the place", () => {
  const image = { centre_px: [100, 100] };
  assert.deepEqual(dragged("rim", image, [0, 0], [130, 140]), { diameter_px: 100 });
  assert.ok(Math.abs(dragged("equator", image, [0, 0], [110, 90]).equator_deg - 45) < 1e-9);
  assert.ok(Math.abs(dragged("equator", image, [0, 0], [90, 110]).equator_deg - 45) < 1e-9);
  const steep = { centre_px: [100, 100], equator_rad: 146 * Math.PI / 180 };
  assert.ok(Math.abs(dragged("equator", steep, [0, 0], [90, 90]).equator_deg - 135) < 1e-9, "its handle does not jump to the other side");
  assert.deepEqual(dragged("centre", image, [103, 100], [105, 98]), { centre: [102, 98] });
});

test("what the host makes of corrected images is laid onto them, each once", () => {
  const items = state.itemsOf(found, state.remove(state.add(state.noEdits, [300, 100], 60).edits, "found-1"));
  const judged = [
    { centre_px: [300.2, 100], flash_index: 5, leg: "rebound", used: true, source: "hand" },
    { centre_px: [100, 200], flash_index: 1, leg: "incoming", used: false, why_not: "why", source: "auto" },
  ];
  const [first, removed, far, added] = withJudgement(items, judged);
  assert.equal(first.image.flash_index, 1);
  assert.equal(first.image.why_not, "why");
  assert.equal(removed.status, "removed");
  assert.equal(far.image.flash_index, 2);
  assert.equal(added.image.flash_index, 5);
  assert.deepEqual(added.image.centre_px, [300, 100]);
});

/// Answers when the test says so.
function slowHost() {
  const waiting = [];
  return {
    asked: [],
    ask(text) {
      this.asked.push(text);
      return new Promise((resolve, reject) => waiting.push({ resolve, reject }));
    },
    async answer(value) {
      waiting.shift().resolve(value);
      await new Promise(setImmediate);
    },
    async refuse(words) {
      waiting.shift().reject(new Error(words));
      await new Promise(setImmediate);
    },
  };
}

function newestOnly(host) {
  const told = [];
  let due = null;
  const preview = createNewestOnly({
    ask: (text) => host.ask(text),
    answered: (answer, text) => told.push([text, answer]),
    failed: (error, text) => told.push([text, error.message]),
    later: (f) => {
      due = f;
      return 1;
    },
    never: () => {
      due = null;
    },
  });
  return {
    preview,
    told,
    moment: () => {
      const f = due;
      due = null;
      f?.();
    },
  };
}

test("while something is dragged the readout follows: what was wanted first does not wait for the last", () => {
  const host = slowHost();
  const { preview, moment } = newestOnly(host);
  preview.want("a");
  preview.want("b");
  moment();
  preview.want("c");
  assert.deepEqual(host.asked, ["b"]);
});

test("many changes in a moment are one question, the newest", async () => {
  const host = slowHost();
  const { preview, told, moment } = newestOnly(host);
  for (const text of ["a", "b", "c"]) preview.want(text);
  moment();
  assert.deepEqual(host.asked, ["c"]);
  await host.answer(1);
  assert.deepEqual(told, [["c", 1]]);
});

test("one question is under way at a time; an answer to what is no longer asked is dropped", async () => {
  const host = slowHost();
  const { preview, told, moment } = newestOnly(host);
  preview.want("a");
  moment();
  preview.want("b");
  moment();
  preview.want("c");
  moment();
  assert.deepEqual(host.asked, ["a"]);
  await host.answer(1);
  assert.deepEqual(host.asked, ["a", "c"]);
  assert.deepEqual(told, []);
  await host.refuse("the host does not answer");
  assert.deepEqual(told, [["c", "the host does not answer"]]);
  preview.want("d");
  moment();
  preview.forget();
  await host.answer(4);
  assert.equal(told.length, 1);
});

test("differences are told in sds of the value before, large ones as large", () => {
  assert.equal(changeWords({ value: 10, sd: 0.5 }, { value: 10.2, sd: 0.4 }), "+0.40 sd");
  assert.equal(changeWords({ value: 10, sd: 0.5 }, { value: 9, sd: 0.4 }), "\u22122.00 sd, large");
  assert.equal(changeWords({ value: 10, sd: 0.5 }, { value: 10, sd: 0.5 }), "none");
  assert.equal(changeWords({ value: null, sd: null }, { value: 3, sd: 1 }), "new");
  assert.equal(changeWords({ value: 3, sd: 1 }, { value: null, sd: null }), "lost");
  const quantities = [
    { name: "e", label: "restitution e", unit: "", essential: true },
    { name: "x", label: "x", unit: "m", essential: false },
  ];
  assert.deepEqual(
    comparisonRows(quantities, { e: { value: 0.876, sd: 0.0026 } }, { e: { value: 0.8773, sd: 0.0026 } }),
    [
      {
        label: "restitution e",
        essential: true,
        before: "0.8760 ± 0.0026",
        after: "0.8773 ± 0.0026",
        change: "+0.50 sd",
      },
    ],
  );
});

test("it is told when corrections make a shot count, or no longer", () => {
  assert.equal(verdictWords({ before: null, after: null }), "");
  assert.equal(verdictWords(undefined), "");
  assert.equal(
    verdictWords({ before: "few images", after: null }),
    "With these corrections the shot counts; before it was rejected: few images.",
  );
  assert.equal(
    verdictWords({ before: null, after: "few images" }),
    "With these corrections the shot is rejected: few images.",
  );
  assert.match(verdictWords({ before: "a", after: "b" }), /still rejected: b/);
});

/// Keys on an image that is chosen and has the focus.
function keyed() {
  const model = modelOf();
  model.select("found-0");
  const stage = { view: () => ({ scale: 1, x: 0, y: 0 }), photoPoint: (at) => at, middle: () => [200, 150] };
  const marks = { keyOf: (target) => target, focus() {} };
  const tool = createTool({ model, stage, marks, escaped: () => true });
  const press = (key, more = {}) => tool.key({ key, target: model.selectedItem()?.key ?? null, ...more });
  return { model, press, image: () => model.selectedItem().image };
}

test("arrows move by a tenth of a px, with Shift by one, up being up on the screen", () => {
  const { press, image } = keyed();
  press("ArrowRight");
  press("ArrowUp", { shiftKey: true });
  const [column, row] = image().centre_px;
  assert.ok(Math.abs(column - 100.1) < 1e-9 && Math.abs(row - 199) < 1e-9);
});

test("after a drag, when the photograph has the focus, keys still move what is chosen; those of another image do not", () => {
  const { press, image } = keyed();
  assert.equal(press("ArrowRight", { target: null }), true);
  assert.ok(Math.abs(image().centre_px[0] - 100.1) < 1e-9);
  assert.equal(press("ArrowRight", { target: "found-1" }), false);
  assert.ok(Math.abs(image().centre_px[0] - 100.1) < 1e-9);
});

test("brackets change the diameter, points the equator, n says that none is seen, Delete removes", () => {
  const { model, press, image } = keyed();
  press("]");
  press("}");
  assert.ok(Math.abs(image().diameter_px - 61.1) < 1e-9);
  press(".");
  press("<");
  assert.ok(Math.abs((image().equator_rad * 180) / Math.PI - ((0.5 * 180) / Math.PI - 0.9)) < 1e-9);
  press("n");
  assert.equal(image().equator_rad, null);
  press("Delete");
  assert.equal(model.selectedItem().status, "removed");
});

test("a goes on to add, Enter adds in the middle of the view, and keys without a chosen image are the view's", () => {
  const { model, press } = keyed();
  press("a");
  assert.ok(model.adding());
  assert.equal(press("Enter"), true);
  assert.deepEqual(model.selectedItem().image.centre_px, [200, 150]);
  model.select(null);
  assert.equal(press("ArrowLeft"), false);
  assert.equal(press("+"), false);
});
