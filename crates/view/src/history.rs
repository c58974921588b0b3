//! Undo and redo.

/// The number of states that are kept. Older ones are forgotten.
const DEPTH: usize = 200;

/// The states before each change, and those after each change that was undone.
#[derive(Debug, Clone)]
pub struct History<T> {
    past: Vec<T>,
    future: Vec<T>,
}

impl<T> Default for History<T> {
    fn default() -> Self {
        Self { past: Vec::new(), future: Vec::new() }
    }
}

impl<T> History<T> {
    /// Records a change. `before` is the state before it.
    pub fn record(&mut self, before: T) {
        if self.past.len() == DEPTH {
            self.past.remove(0);
        }
        self.past.push(before);
        self.future.clear();
    }

    /// Restores the state before the last change. `false` where there is no change.
    pub fn undo(&mut self, state: &mut T) -> bool {
        swap(&mut self.past, &mut self.future, state)
    }

    /// Restores the change that was undone last. `false` where none was undone.
    pub fn redo(&mut self, state: &mut T) -> bool {
        swap(&mut self.future, &mut self.past, state)
    }

    /// Whether there is a change to undo, and one to redo.
    pub fn can(&self) -> [bool; 2] {
        [&self.past, &self.future].map(|states| !states.is_empty())
    }
}

fn swap<T>(from: &mut Vec<T>, to: &mut Vec<T>, state: &mut T) -> bool {
    let Some(other) = from.pop() else { return false };
    to.push(std::mem::replace(state, other));
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_undone_and_done_again() {
        let (mut state, mut history) = (1, History::default());
        assert!(!history.undo(&mut state) && !history.redo(&mut state));
        for next in 2..=4 {
            history.record(state);
            state = next;
        }
        assert!(history.undo(&mut state) && history.undo(&mut state));
        assert_eq!((state, history.can()), (2, [true, true]));
        assert!(history.redo(&mut state));
        assert_eq!(state, 3);
        // After another change, undone changes are gone.
        history.record(state);
        state = 9;
        assert!(!history.redo(&mut state) && history.undo(&mut state));
        assert_eq!(state, 3);
    }

    #[test]
    fn it_does_not_grow_without_end() {
        let mut history = History::default();
        (0..10_000).for_each(|i| history.record(i));
        assert_eq!(history.past.len(), DEPTH);
        assert_eq!(history.past.last(), Some(&9_999));
    }
}
