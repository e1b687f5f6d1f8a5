// Steps of an edit, to be taken back and done again. What a key does while it is held is one step with its first press. Pure.

export function createUndo(first) {
  let past = [];
  let future = [];
  let now = { state: first, words: "", open: false };
  return {
    state: () => now.state,
    canUndo: () => past.length > 0,
    canRedo: () => future.length > 0,
    /// words: what was done, for the button: "move image of flash 3".
    push(state, words, held = false) {
      if (!(held && now.open && now.words === words)) past.push({ ...now, open: false });
      now = { state, words, open: true };
      future = [];
    },
    /// The words of what is taken back; null: there is nothing.
    undo() {
      if (past.length === 0) return null;
      const undone = now;
      future.push({ ...now, open: false });
      now = past.pop();
      return undone.words;
    },
    redo() {
      if (future.length === 0) return null;
      past.push(now);
      now = future.pop();
      return now.words;
    },
  };
}
