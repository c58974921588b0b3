//! Which shapes the name of a curve means: `EyeBlinkLeft`, `eyeBlink_L` and `CTRL_expressions_eyeBlinkL` are
//! one name.
use std::collections::HashMap;

/// ARKit's names of blend shapes without their sides, in small letters.
pub(super) const ARKIT: [&str; 37] = [
    "browdown",
    "browinnerup",
    "browouterup",
    "cheekpuff",
    "cheeksquint",
    "eyeblink",
    "eyelookdown",
    "eyelookin",
    "eyelookout",
    "eyelookup",
    "eyesquint",
    "eyewide",
    "jaw",
    "jawforward",
    "jawopen",
    "mouth",
    "mouthclose",
    "mouthdimple",
    "mouthfrown",
    "mouthfunnel",
    "mouthlowerdown",
    "mouthpress",
    "mouthpucker",
    "mouthrolllower",
    "mouthrollupper",
    "mouthshruglower",
    "mouthshrugupper",
    "mouthsmile",
    "mouthstretch",
    "mouthupperup",
    "nosesneer",
    "tongueout",
    // Some programs say `Up` and `Down` last.
    "mouthuplower",
    "mouthrollup",
    "mouthrolldown",
    "mouthshrugup",
    "mouthshrugdown",
];

/// The side of a face, as the person who owns it says it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Side {
    Left,
    Right,
}

/// A name without its spelling.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Key {
    /// The words in small letters, without the side.
    pub(super) base: String,
    pub(super) side: Option<Side>,
}

impl Key {
    pub(super) fn of(name: &str) -> Self {
        // Programs put the object or the group first: `head|blendShape1.jawOpen`.
        let last = name.rsplit(['.', ':', '|', '/']).find(|part| !part.trim().is_empty()).unwrap_or(name);
        let words = words(last);
        let last_word = words.len().saturating_sub(1);
        let first = words.iter().take(last_word).take_while(|word| PREFIXES.contains(&&***word)).count();
        let mut words = &words[first..];
        let mut side = None;
        if let [begins, .., ends] = words {
            if let Some(found) = side_of(ends) {
                words = &words[..words.len() - 1];
                side = Some(found);
            } else if let Some(found) = side_of(begins) {
                words = &words[1..];
                side = Some(found);
            }
        }
        let mut base = words.concat();
        if side.is_none() {
            for (ending, of_ending) in [("left", Side::Left), ("right", Side::Right)] {
                if let Some(rest) = base.strip_suffix(ending).filter(|rest| !rest.is_empty()) {
                    side = Some(of_ending);
                    base = rest.to_owned();
                    break;
                }
            }
        }
        Self { base, side }
    }
}

/// Words that stand before the names of shapes and say nothing.
const PREFIXES: [&str; 9] =
    ["ctrl", "expressions", "bs", "blend", "blendshape", "blendshapes", "arkit", "morph", "shape"];

fn side_of(word: &str) -> Option<Side> {
    match word {
        "l" | "left" | "lf" | "lft" => Some(Side::Left),
        "r" | "right" | "rt" | "rgt" => Some(Side::Right),
        _ => None,
    }
}

/// The words of a name in small letters: `CTRL_eyeBlinkL` has `ctrl`, `eye`, `blink` and `l`.
pub(super) fn words(name: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut begins = true;
    let mut before = ' ';
    let mut letters = name.chars().peekable();
    while let Some(c) = letters.next() {
        if !c.is_alphanumeric() {
            begins = true;
            before = c;
            continue;
        }
        let next_is_small = letters.peek().is_some_and(|next| next.is_lowercase());
        let is_hump = c.is_uppercase() && (!before.is_uppercase() || next_is_small);
        if begins || is_hump {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut() {
            word.extend(c.to_lowercase());
        }
        begins = false;
        before = c;
    }
    words
}

/// What the names of curves mean.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Meant {
    /// For each curve, the shapes that it moves, as indices. A curve without a side moves both shapes that
    /// have one.
    pub shapes: Vec<Vec<usize>>,
    /// Pairs of curves of which only the first is used, since both mean the same shape.
    pub twice: Vec<[usize; 2]>,
}

/// Finds the shapes that curves move, by their names in any spelling. An equal name comes first. Then the
/// same words on the same side do. Last, a curve without a side moves the shapes of both sides that no other
/// curve moves.
pub fn meant(curves: &[String], shapes: &[String]) -> Meant {
    let mut by_name: HashMap<&str, usize> = HashMap::new();
    let mut by_key: HashMap<Key, usize> = HashMap::new();
    for (i, shape) in shapes.iter().enumerate() {
        by_name.entry(shape).or_insert(i);
        by_key.entry(Key::of(shape)).or_insert(i);
    }
    let mut out = Meant { shapes: vec![Vec::new(); curves.len()], twice: Vec::new() };
    // The curve that moves each shape.
    let mut taken: Vec<Option<usize>> = vec![None; shapes.len()];
    let mut take = |out: &mut Meant, curve: usize, shape: Option<usize>, may_be_taken: bool| {
        let Some(shape) = shape else { return };
        match taken[shape] {
            None => {
                taken[shape] = Some(curve);
                out.shapes[curve].push(shape);
            }
            Some(first) if first != curve && !may_be_taken => out.twice.push([first, curve]),
            Some(_) => {}
        }
    };
    for (i, curve) in curves.iter().enumerate() {
        take(&mut out, i, by_name.get(&**curve).copied(), false);
    }
    let keys: Vec<Key> = curves.iter().map(|curve| Key::of(curve)).collect();
    for (i, key) in keys.iter().enumerate() {
        if out.shapes[i].is_empty() {
            take(&mut out, i, by_key.get(key).copied(), false);
        }
    }
    for (i, key) in keys.iter().enumerate() {
        if out.shapes[i].is_empty() && key.side.is_none() {
            for side in [Side::Left, Side::Right] {
                let sided = Key { base: key.base.clone(), side: Some(side) };
                take(&mut out, i, by_key.get(&sided).copied(), true);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_of_one_name_are_one_key() {
        let key = |base: &str, side| Key { base: base.into(), side };
        for name in [
            "eyeBlinkLeft",
            "EyeBlinkLeft",
            "eyeBlink_L",
            "EYEBLINK_L",
            "eye_blink_left",
            "eyeblinkleft",
            "Left_EyeBlink",
            "CTRL_expressions_eyeBlinkL",
            "blendShapes.EyeBlinkLeft",
            "head|blendShape1.eyeBlink_L",
            "eye blink L",
            "arkit_eyeBlinkLeft",
        ] {
            assert_eq!(Key::of(name), key("eyeblink", Some(Side::Left)), "{name}");
        }
        assert_eq!(Key::of("mouthRight"), key("mouth", Some(Side::Right)));
        assert_eq!(Key::of("jawOpen"), key("jawopen", None));
        assert_eq!(Key::of("L"), key("l", None));
        assert_eq!(Key::of(""), key("", None));
    }

    #[test]
    fn curves_find_their_shapes() {
        let names = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
        let shapes = names(&["jawOpen", "mouthSmile_L", "mouthSmile_R", "browInnerUp_L", "browInnerUp_R"]);
        let curves =
            names(&["JawOpen", "MouthSmileLeft", "BrowInnerUp", "TongueOut", "mouthSmile", "jaw_open"]);
        let found = meant(&curves, &shapes);
        // A curve without a side takes only what no other curve moves: the right smile.
        assert_eq!(found.shapes, [vec![0], vec![1], vec![3, 4], vec![], vec![2], vec![]]);
        assert_eq!(found.twice, [[0, 5]]);
    }

    #[test]
    fn an_equal_name_comes_before_another_spelling() {
        let names = ["a_b".to_owned(), "aB".to_owned()];
        assert_eq!(meant(&names, &names).shapes, [vec![0], vec![1]]);
    }
}
