//! Which shapes of a file belong together, and how alike two shapes are.

use super::shapes::Shape;
use std::collections::HashMap;

/// Shapes that are one expression: those of both sides, or one alone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ShapeGroup {
    /// The name without its side; the shape's own name if it is alone.
    pub name: String,
    /// The numbers of its shapes, ascending.
    pub shapes: Vec<usize>,
}

/// Words for left and right in names of shapes.
const SIDES: [[&str; 2]; 5] =
    [["Left", "Right"], ["left", "right"], ["LEFT", "RIGHT"], ["L", "R"], ["l", "r"]];

/// Two shapes that are more [alike](likeness) than this teach a solve nothing apart.
pub const ALIKE: f64 = 0.98;

/// Shapes of two sides whose displacements are more opposite than this cancel out, as jawLeft and jawRight.
const OPPOSITE: f64 = -0.2;

/// Puts shapes of the left and right side together, such as `eyeBlinkLeft` and `eyeBlinkRight`, or `smile_L`
/// and `smile_R`. Groups are in the order of their first shapes, and no two have the same name.
///
/// ```
/// # use rhytid_meshes::{Shape, shape_groups};
/// let shape = |name: &str, v: u32| Shape { name: name.into(), moved: vec![(v, [0.0, 1.0, 0.0])] };
/// let groups = shape_groups(&[shape("blink_L", 0), shape("smile", 1), shape("blink_R", 2)]);
/// assert_eq!((groups[0].name.as_str(), &*groups[0].shapes), ("blink", &[0, 2][..]));
/// assert_eq!((groups[1].name.as_str(), &*groups[1].shapes), ("smile", &[1][..]));
/// ```
pub fn shape_groups(shapes: &[Shape]) -> Vec<ShapeGroup> {
    let numbers: HashMap<&str, usize> = shapes.iter().map(|shape| &*shape.name).zip(0..).collect();
    let mut taken = vec![false; shapes.len()];
    let mut groups: Vec<ShapeGroup> = Vec::new();
    for (i, shape) in shapes.iter().enumerate() {
        if taken[i] {
            continue;
        }
        taken[i] = true;
        let mut group = ShapeGroup { name: shape.name.clone(), shapes: vec![i] };
        for Sided { other, without } in sided(&shape.name) {
            let Some(&other) = numbers.get(other.as_str()) else { continue };
            let is_name = numbers.contains_key(without.as_str()) || groups.iter().any(|g| g.name == without);
            if taken[other] || is_name || likeness(shape, &shapes[other]) < OPPOSITE {
                continue;
            }
            taken[other] = true;
            group = ShapeGroup { name: without, shapes: vec![i, other] };
            break;
        }
        groups.push(group);
    }
    groups
}

/// A reading of a name as that of one side.
struct Sided {
    /// The name of the other side.
    other: String,
    /// The name without a side.
    without: String,
}

/// Each way to read a name as that of one side.
fn sided(name: &str) -> Vec<Sided> {
    let mut found = Vec::new();
    for sides in SIDES {
        for (side, word) in sides.iter().enumerate() {
            for (at, _) in name.match_indices(word) {
                let (before, after) = (&name[..at], &name[at + word.len()..]);
                // A single letter stands alone. A word may be a part of one in camel case.
                let ends = |c: char| !c.is_alphanumeric();
                let is_whole =
                    before.chars().next_back().is_none_or(ends) && after.chars().next().is_none_or(ends);
                let is_word = word.len() > 1 && !after.starts_with(|c: char| c.is_lowercase());
                let is_begun =
                    !before.ends_with(|c: char| c.is_lowercase()) || word.starts_with(char::is_uppercase);
                if !(is_whole || is_word && is_begun) {
                    continue;
                }
                let other = format!("{before}{}{after}", sides[1 - side]);
                let kept = format!("{}{after}", before.trim_end_matches(['_', '.', '-', ' ']));
                let without = kept.trim_start_matches(['_', '.', '-', ' ']).to_owned();
                if !without.is_empty() {
                    found.push(Sided { other, without });
                }
            }
        }
    }
    found
}

/// How alike the displacements of two shapes are, from -1 to 1: the cosine of the angle between them. 1 is
/// the same up to a factor, and 0 has nothing in common. 0 if one moves nothing.
pub fn likeness(a: &Shape, b: &Shape) -> f64 {
    let length = |shape: &Shape| shape.moved.iter().flat_map(|(_, by)| by).map(|x| x * x).sum::<f64>().sqrt();
    let by_vertex: HashMap<u32, [f64; 3]> = b.moved.iter().copied().collect();
    let mut product = 0.0;
    for (v, by) in &a.moved {
        if let Some(other) = by_vertex.get(v) {
            product += (0..3).map(|c| by[c] * other[c]).sum::<f64>();
        }
    }
    let lengths = length(a) * length(b);
    if lengths > 0.0 { product / lengths } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(name: &str, moved: &[(u32, [f64; 3])]) -> Shape {
        Shape { name: name.to_owned(), moved: moved.to_vec() }
    }

    fn groups(names: &[&str]) -> Vec<(String, Vec<usize>)> {
        let shapes: Vec<Shape> =
            names.iter().zip(0..).map(|(name, v)| shape(name, &[(v, [0.0, 1.0, 0.0])])).collect();
        shape_groups(&shapes).into_iter().map(|group| (group.name, group.shapes)).collect()
    }

    #[test]
    fn sides_are_found_as_people_write_them() {
        for [left, right, both] in [
            ["eyeBlinkLeft", "eyeBlinkRight", "eyeBlink"],
            ["mouthLeftUp", "mouthRightUp", "mouthUp"],
            ["blink_L", "blink_R", "blink"],
            ["blink.l", "blink.r", "blink"],
            ["L_brow_up", "R_brow_up", "brow_up"],
            ["brow_l_up", "brow_r_up", "brow_up"],
            ["left brow", "right brow", "brow"],
            ["browLEFT", "browRIGHT", "brow"],
        ] {
            assert_eq!(groups(&[left, "jawOpen", right])[0], (both.to_owned(), vec![0, 2]), "{left}");
        }
        for alone in
            [["lift", "rift"], ["Leftover", "Rightover"], ["smile", "frown"], ["bell", "berr"], ["L", "R"]]
        {
            assert_eq!(groups(&alone).len(), 2, "{alone:?}");
        }
        // A name that is there already stays that of its own shape.
        assert_eq!(groups(&["blink_L", "blink_R", "blink"]).len(), 3);
        assert_eq!(groups(&["a_L", "a_R", "a.L", "a.R"])[1..].len(), 2);
    }

    #[test]
    fn opposite_sides_stay_apart() {
        let jaw = [shape("jawLeft", &[(0, [1.0, 0.0, 0.1])]), shape("jawRight", &[(0, [-1.0, 0.0, 0.1])])];
        assert_eq!(shape_groups(&jaw).len(), 2);
    }

    #[test]
    fn likeness_is_a_cosine() {
        let a = shape("a", &[(0, [1.0, 0.0, 0.0]), (3, [0.0, 2.0, 0.0])]);
        assert!((likeness(&a, &a) - 1.0).abs() < 1e-12);
        let b = shape("b", &[(3, [0.0, -1.0, 0.0])]);
        assert!((likeness(&a, &b) + 2.0 / 5.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!(likeness(&a, &shape("c", &[(1, [1.0, 1.0, 1.0])])), 0.0);
        assert_eq!(likeness(&a, &shape("d", &[])), 0.0);
    }
}
