//! The tables of the things that a crate file refers to by number: tokens, strings and paths, each once.
use std::collections::HashMap;

/// Tokens, and the strings, which are numbered apart and stand for tokens.
#[derive(Default)]
pub(super) struct Words {
    pub(super) tokens: Vec<String>,
    number_of_token: HashMap<String, u32>,
    /// The token of each string.
    pub(super) strings: Vec<u32>,
    number_of_string: HashMap<u32, u32>,
}

impl Words {
    /// The number of a token. Zero ends a token in the file, so that it cannot be part of one; it becomes
    /// U+FFFD.
    pub(super) fn token(&mut self, text: &str) -> u32 {
        if let Some(&number) = self.number_of_token.get(text) {
            return number;
        }
        let stored = text.replace('\0', "\u{fffd}");
        if stored != text {
            return self.token(&stored);
        }
        let number = self.tokens.len() as u32;
        self.tokens.push(stored.clone());
        self.number_of_token.insert(stored, number);
        number
    }

    /// The number of a string.
    pub(super) fn string(&mut self, text: &str) -> u32 {
        let token = self.token(text);
        *self.number_of_string.entry(token).or_insert_with(|| {
            self.strings.push(token);
            self.strings.len() as u32 - 1
        })
    }
}

/// A tree of paths. Path 0 is the root.
pub(super) struct Paths {
    /// For each path, the element that it adds to its parent: the token of a prim, or the negated token of a
    /// property. `None` for the empty path, which is not in the tree.
    elements: Vec<Option<i32>>,
    children: Vec<Vec<u32>>,
    number_of: HashMap<(u32, i32), u32>,
    empty: Option<u32>,
}

/// The tree, parents before children: three numbers for each path that is in it.
#[derive(Default)]
pub(super) struct Tree {
    /// The number of the path.
    pub(super) paths: Vec<i32>,
    /// What it adds to its parent.
    pub(super) elements: Vec<i32>,
    /// -2: no child and no sibling follows; -1: a child; 0: a sibling; otherwise a child follows, and the
    /// sibling is that many places further.
    pub(super) jumps: Vec<i32>,
}

impl Paths {
    pub(super) const ROOT: u32 = 0;

    /// The root alone, to which `element` is of no meaning.
    pub(super) fn new() -> Self {
        Self { elements: vec![Some(0)], children: vec![Vec::new()], number_of: HashMap::new(), empty: None }
    }

    /// The prim that is called by the token `name`, below `parent`.
    pub(super) fn prim(&mut self, parent: u32, name: u32) -> u32 {
        self.child(parent, name as i32)
    }

    /// The property that is called by the token `name`, of `prim`. Token 0 cannot be negated and must not be
    /// one.
    pub(super) fn property(&mut self, prim: u32, name: u32) -> u32 {
        self.child(prim, -(name as i32))
    }

    fn child(&mut self, parent: u32, element: i32) -> u32 {
        if let Some(&number) = self.number_of.get(&(parent, element)) {
            return number;
        }
        let number = self.push(Some(element));
        self.children[parent as usize].push(number);
        self.number_of.insert((parent, element), number);
        number
    }

    fn push(&mut self, element: Option<i32>) -> u32 {
        self.elements.push(element);
        self.children.push(Vec::new());
        self.elements.len() as u32 - 1
    }

    /// The path in `text`: absolute, of a prim or a property; or empty.
    pub(super) fn parse(&mut self, text: &str, words: &mut Words) -> u32 {
        if text.is_empty() {
            if let Some(number) = self.empty {
                return number;
            }
            let number = self.push(None);
            self.empty = Some(number);
            return number;
        }
        let (prims, property) =
            text.split_once('.').map_or((text, None), |(prims, name)| (prims, Some(name)));
        let mut path = Self::ROOT;
        for name in prims.split('/').filter(|name| !name.is_empty()) {
            path = self.prim(path, words.token(name));
        }
        property.map_or(path, |name| self.property(path, words.token(name)))
    }

    /// How many there are, the empty path with them.
    pub(super) fn len(&self) -> usize {
        self.elements.len()
    }

    /// The tree in order.
    pub(super) fn tree(&self) -> Tree {
        let mut tree = Tree::default();
        // Each with whether a sibling follows it; and where to write how far that is.
        let mut open = vec![(Self::ROOT, false, None::<usize>)];
        while let Some((path, sibling_follows, jump_to_fill)) = open.pop() {
            let here = tree.paths.len();
            if let Some(before) = jump_to_fill {
                tree.jumps[before] = (here - before) as i32;
            }
            let children = &self.children[path as usize];
            tree.paths.push(path as i32);
            tree.elements.push(self.elements[path as usize].unwrap_or(0));
            tree.jumps.push(match (children.is_empty(), sibling_follows) {
                (true, false) => -2,
                (false, false) => -1,
                (true, true) | (false, true) => 0,
            });
            // The sibling waits below the children on the stack, and is told where this one stands.
            if sibling_follows
                && !children.is_empty()
                && let Some(sibling) = open.last_mut()
            {
                sibling.2 = Some(here);
            }
            for (i, &child) in children.iter().enumerate().rev() {
                open.push((child, i + 1 < children.len(), None));
            }
        }
        tree
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_says_where_siblings_stand() {
        let (mut words, mut paths) = (Words::default(), Paths::new());
        words.token("");
        for path in ["/a/b", "/a/b.x", "/a.y", "", "/c", "/a/b/d", "/a.y", "/", ""] {
            paths.parse(path, &mut words);
        }
        let tree = paths.tree();
        let names: Vec<String> = tree
            .elements
            .iter()
            .map(|&e| format!("{}{}", if e < 0 { "." } else { "" }, words.tokens[e.unsigned_abs() as usize]))
            .collect();
        assert_eq!(names, ["", "a", "b", ".x", "d", ".y", "c"]);
        assert_eq!(tree.jumps, [-1, 5, 3, 0, -2, -2, -2]);
        assert_eq!((paths.len(), tree.paths.len()), (8, 7), "the empty path is not in the tree");
    }
}
