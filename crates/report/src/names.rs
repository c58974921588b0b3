//! Names beside dots in a picture.

use rhytid_render::SMALL;

/// The distance of a name from the middle of its dot, in pixels.
const BESIDE: i32 = 7;

/// The part of a dot that no name may hide, in pixels from its middle.
const DOT: i32 = 4;

/// A longer name is cut, so that it does not hide half of the face.
const LETTERS: usize = 14;

/// A name in a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Name<'a> {
    pub words: &'a str,
    /// Its upper left corner, in pixels.
    pub at: [i32; 2],
}

/// A box of pixels: its upper left and its lower right corner.
#[derive(Clone, Copy)]
struct Area {
    low: [i32; 2],
    high: [i32; 2],
}

impl Area {
    fn meets(&self, other: &Self) -> bool {
        (0..2).all(|c| self.low[c] < other.high[c] && other.low[c] < self.high[c])
    }
}

/// Places each of `words` beside its dot, where it hides no dot and no other name. A name without room is
/// left out, and so is one whose dot is outside the picture of `size` pixels.
pub(crate) fn place_names<'a>(dots: &[[f32; 2]], words: &[&'a str], size: [u32; 2]) -> Vec<Name<'a>> {
    let picture = Area { low: [0, 0], high: size.map(|n| n as i32) };
    let around = |[x, y]: [f32; 2]| {
        let [x, y] = [x.round() as i32, y.round() as i32];
        Area { low: [x - DOT, y - DOT], high: [x + DOT, y + DOT] }
    };
    let mut taken: Vec<Area> = dots.iter().copied().map(around).collect();
    let mut names = Vec::new();
    for (dot, words) in dots.iter().zip(words) {
        let words = match words.char_indices().nth(LETTERS) {
            Some((end, _)) => &words[..end],
            None => words,
        };
        let [x, y] = [dot[0].round() as i32, dot[1].round() as i32];
        let [wide, high] = [words.chars().count() as i32 * SMALL[0] as i32, SMALL[1] as i32];
        let (right, left, middle) = (x + BESIDE, x - BESIDE - wide, x - wide / 2);
        let (above, below, beside) = (y - BESIDE - high, y + BESIDE, y - high / 2);
        let places = [
            [right, beside],
            [left, beside],
            [middle, above],
            [middle, below],
            [right, above],
            [right, below],
            [left, above],
            [left, below],
        ];
        for at in places {
            let area = Area { low: at, high: [at[0] + wide, at[1] + high] };
            let is_inside = (0..2).all(|c| area.low[c] >= picture.low[c] && area.high[c] <= picture.high[c]);
            if is_inside && taken.iter().all(|other| !area.meets(other)) {
                taken.push(area);
                names.push(Name { words, at });
                break;
            }
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_hide_neither_dots_nor_each_other() {
        let dots: Vec<[f32; 2]> =
            (0..80_u8).map(|i| [f32::from(i % 10) * 40.0, f32::from(i / 10) * 24.0]).collect();
        let words: Vec<String> = (0..80).map(|i| format!("m{i:02}")).collect();
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let names = place_names(&dots, &words, [400, 200]);
        assert!(names.len() > 70, "{}", names.len());
        let area = |name: &Name<'_>| [name.at, [name.at[0] + 27, name.at[1] + 15]];
        for (i, name) in names.iter().enumerate() {
            let [low, high] = area(name);
            assert!(low[0] >= 0 && low[1] >= 0 && high[0] <= 400 && high[1] <= 200);
            for [x, y] in &dots {
                let is_in = |x: f32, c: usize| x > low[c] as f32 && x < high[c] as f32;
                assert!(!(is_in(*x, 0) && is_in(*y, 1)), "{name:?} hides the dot at {x}, {y}");
            }
            for other in &names[..i] {
                let [a, b] = area(other);
                assert!(
                    a[0] >= high[0] || low[0] >= b[0] || a[1] >= high[1] || low[1] >= b[1],
                    "{name:?} {other:?}"
                );
            }
        }
        // One that has room on neither side is left out; a long one is cut.
        assert!(place_names(&[[5.0, 5.0]], &["name"], [12, 12]).is_empty());
        assert_eq!(
            place_names(&[[5.0, 50.0]], &["abcdefghijklmnopq"], [300, 100])[0].words,
            "abcdefghijklmn"
        );
    }
}
