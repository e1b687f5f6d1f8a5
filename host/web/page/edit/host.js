// What the editor asks of the host (failures are errors whose message can be shown), and what it keeps in this tab.
import { getJson, path, postJson } from "../live/api.js";

export function createRequests(session, shot) {
  const at = (name) => path("sessions", session, "shots", shot, name);
  return {
    /// {found: {images, surface_px, unmeasured}, corrections: [...]}: what the digitizer found, and the corrections that count.
    corrections: () => getJson(at("corrections")),
    preview: (text) => postJson(at("preview"), { corrections: text }),
    save: (text) => postJson(at("corrections"), { corrections: text }),
    undo: () => postJson(at("undo"), {}),
    quantities: () => getJson(path("quantities")),
  };
}

/// Asks for the newest only: has one question under way at a time, the next one a moment after it was wanted or when the one
/// before is answered, and drops answers to what is no longer asked. ask(text) -> promise; answered(answer, text),
/// failed(error, text): for the newest only; busy(whether).
export function createNewestOnly({ ask, answered, failed, busy = () => {}, delay_ms = 50, later = setTimeout, never = clearTimeout }) {
  let wanted = null;
  let timer = null;
  let underWay = false;

  async function send() {
    timer = null;
    if (underWay || wanted === null) return;
    const text = wanted;
    underWay = true;
    let outcome;
    try {
      const answer = await ask(text);
      outcome = () => answered(answer, text);
    } catch (error) {
      outcome = () => failed(error, text);
    }
    underWay = false;
    if (text === wanted) {
      wanted = null;
      busy(false);
      outcome();
    } else if (timer === null && wanted !== null) {
      send();
    }
  }

  return {
    want(text) {
      wanted = text;
      busy(true);
      if (timer === null && !underWay) timer = later(send, delay_ms);
    },
    /// What is under way is no longer of interest.
    forget() {
      wanted = null;
      if (timer !== null) never(timer);
      timer = null;
      busy(false);
    },
  };
}

const nameOf = (session, shot) => `strobe-corrections ${session} ${shot}`;

/// What the edits refer to: those of other images would mean others.
const basis = (found) => JSON.stringify(found.images.map((image) => image.centre_px.map(Math.round)));

/// Corrections that are not saved yet outlive a reload of the page and a look at another view: they are kept in this tab.
export function keepDraft(session, shot, found, edits) {
  try {
    if (edits === null) sessionStorage.removeItem(nameOf(session, shot));
    else sessionStorage.setItem(nameOf(session, shot), JSON.stringify({ basis: basis(found), edits }));
  } catch {
    // private windows may have no storage: the edits are still on the page
  }
}

function kept(session, shot) {
  try {
    return JSON.parse(sessionStorage.getItem(nameOf(session, shot)) ?? "null");
  } catch {
    return null;
  }
}

/// Whether there are any, whatever they refer to.
export const hasDraft = (session, shot) => kept(session, shot) !== null;

export function readDraft(session, shot, found) {
  const draft = kept(session, shot);
  return draft?.basis === basis(found) ? draft.edits : null;
}
