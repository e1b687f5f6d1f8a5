// A few numbers of a shot that fill the screen, to be read from across the room: those that a person has chosen.
import { unitWords, valueAndSd } from "../words/numbers.js";
import { h } from "./dom.js";
import { keptDetails } from "./shot_details.js";

const FIRST_CHOICE = ["vx_td_mps", "omega_lo_radps", "e", "mu"];
const STORED_AS = "afar";

let names = stored() ?? FIRST_CHOICE;

/// What was chosen before, in this browser.
function stored() {
  try {
    const list = JSON.parse(localStorage.getItem(STORED_AS));
    return Array.isArray(list) ? list : null;
  } catch {
    return null;
  }
}

function keep(chosen) {
  names = chosen;
  try {
    localStorage.setItem(STORED_AS, JSON.stringify(chosen));
  } catch {
    // private windows may have no storage: it holds as long as the page is open
  }
}

/// kept: {open: Set of ids}; onchange: others were chosen. Numbers have one digit of their standard uncertainty.
export function afarNumbers(quantities, shot, kept, onchange) {
  const shown = quantities.filter((q) => names.includes(q.name));
  const choose = ({ name }, wanted) => {
    const others = names.filter((other) => other !== name);
    keep(wanted ? [...others, name] : others);
    onchange();
  };
  const box = (q) => {
    const onclick = ({ target }) => choose(q, target.checked);
    const attributes = { type: "checkbox", checked: names.includes(q.name), onclick };
    return h("label", { class: "choice" }, h("input", attributes), h("span", {}, q.label));
  };
  return [
    h("dl", { class: shown.length > 4 ? "afar-numbers many" : "afar-numbers" }, shown.map((q) => number(q, shot))),
    keptDetails(kept, "afar-choice", "Which numbers", h("div", { class: "links" }, quantities.map(box))),
  ];
}

function number(q, shot) {
  const { value, sd } = valueAndSd(shot.values?.[q.name], 1);
  const unit = q.unit && h("span", { class: "unit" }, ` ${unitWords(q.unit)}`);
  return h("div", {}, h("dt", {}, q.label, unit), h("dd", {}, value, sd && h("span", { class: "sd" }, ` ± ${sd}`)));
}
