//! The names of clips.

use crate::{Options, Scene};
use std::collections::HashSet;

impl Scene<'_> {
    /// The names of the clips, all different: those that `options` give, else the mesh's.
    pub fn clip_names(&self, options: &Options) -> Vec<String> {
        let wanted = |i: usize| options.clips.get(i).map_or(self.name, String::as_str);
        unique_names((0..=self.further.len()).map(wanted))
    }
}

/// The names, with a number behind those that another one has too, except for the first.
pub fn unique_names<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    let wanted: Vec<&str> = names.collect();
    let mut taken: HashSet<String> = wanted.iter().map(|name| (*name).to_owned()).collect();
    let mut seen = HashSet::new();
    let named = |name: &str| {
        if seen.insert(name.to_owned()) {
            return name.to_owned();
        }
        let free = (2_u64..).map(|n| format!("{name} {n}")).find(|other| !taken.contains(other));
        let free = free.unwrap_or_else(|| name.to_owned());
        taken.insert(free.clone());
        free
    };
    wanted.into_iter().map(named).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_clips_have_one_name() {
        let names = ["walk", "run", "walk", "walk 2", "walk", ""];
        assert_eq!(unique_names(names.into_iter()), ["walk", "run", "walk 3", "walk 2", "walk 4", ""]);
    }
}
