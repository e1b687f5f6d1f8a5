// Corrections that are not saved yet outlive a reload of the page and a look at another view: they are kept in this tab.

const nameOf = (session, shot) => `strobe-corrections ${session} ${shot}`;

/// What the edits refer to: those of other images would mean others.
const basis = (found) => JSON.stringify(found.images.map((image) => image.centre_px.map(Math.round)));

export function keepDraft(session, shot, found, edits) {
  try {
    if (edits === null) sessionStorage.removeItem(nameOf(session, shot));
    else sessionStorage.setItem(nameOf(session, shot), JSON.stringify({ basis: basis(found), edits }));
  } catch {
    // private windows may have no storage: the edits are still on the page
  }
}

/// Whether there are any, whatever they refer to.
export function hasDraft(session, shot) {
  try {
    return sessionStorage.getItem(nameOf(session, shot)) !== null;
  } catch {
    return false;
  }
}

export function readDraft(session, shot, found) {
  try {
    const draft = JSON.parse(sessionStorage.getItem(nameOf(session, shot)) ?? "null");
    return draft?.basis === basis(found) ? draft.edits : null;
  } catch {
    return null;
  }
}
