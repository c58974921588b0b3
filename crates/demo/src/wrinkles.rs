//! Wrinkles: heights along the normal, in centimetres, between the markers.
//!
//! Skin does not wrinkle like a sine. It bulges roundly between narrow, sharp valleys. The valleys wander,
//! break off and differ from side to side.
use crate::curve::{bell, noise, pair, plateau, ramp};
use crate::skin::Skin;

/// A row of wrinkles: valleys where `phase` is a whole number, round bulges between; about 1 from floor to
/// crest.
fn row(phase: f64) -> f64 {
    let s = (std::f64::consts::PI * phase).sin();
    (s * s + 0.004).sqrt().powf(0.75) - 0.72
}

/// One furrow at distance `t`: a valley of depth 1 and half width `width` between two low bulges.
fn furrow(t: f64, width: f64) -> f64 {
    let q = t / width;
    0.45 * bell(q.abs(), 2.4, 1.5) - (-(q * q + 0.05).sqrt() * 1.3 + 0.29).exp()
}

/// The strength of wrinkle number `phase` at `along`: wrinkles come and go along their length.
fn broken(phase: f64, along: f64, seed: u32) -> f64 {
    0.72 + 0.5 * noise(along, 0.8 * phase, seed).clamp(-0.9, 0.55)
}

/// Five lines across the forehead, arched like the brows.
pub(crate) fn brow_raise(s: &Skin) -> f64 {
    let (x, y, side) = (s.p.x, s.site.up, s.site.across.abs());
    let arch = 0.3 * ramp(side, 0.2, 3.2) - 0.75 * ramp(side, 3.2, 6.4);
    let wander = 0.16 * noise(x / 1.7, y / 1.2, 11) + 0.06 * noise(x / 0.6, y / 0.7, 12);
    let height = y - arch + wander;
    let phase = (height - 3.05) / 0.72;
    let strength = 0.8 + 0.35 * noise(x / 1.5, 0.8 * phase, 13);
    let region = plateau(height, 3.2, 6.1, 0.75) * ramp(side, 6.3, 3.4);
    let fine = 0.16 * row(2.0 * phase + 0.3 * noise(x, y, 14));
    0.135 * region * (strength * row(phase) + fine)
}

/// The two lines between the brows, their weaker neighbours, and the line across the root of the nose.
pub(crate) fn frown(s: &Skin) -> f64 {
    let (x, y) = (s.p.x, s.site.up);
    let wander = 0.06 * noise(y / 0.8, 0.0, 21);
    let lean = 0.1 * (y - 1.4) + 0.05 * (y - 1.4) * (y - 1.4);
    let tall = plateau(y, 1.25, 2.9, 0.7);
    let main =
        0.15 * (furrow(x - 0.46 - lean + wander, 0.15) + 0.85 * furrow(x + 0.42 + lean + wander, 0.14));
    let second = 0.07 * (furrow(x - 1.15 - 1.6 * lean, 0.13) + furrow(x + 1.2 + 1.6 * lean, 0.13));
    let between = 0.04 * furrow(x + 0.03 + wander, 0.1) * plateau(y, 1.6, 2.3, 0.5);
    let root = 0.11 * furrow(y - 0.72 + 0.12 * x * x, 0.16) * ramp(x.abs(), 1.1, 0.4);
    let root2 = 0.06 * furrow(y - 1.12 + 0.1 * x * x, 0.13) * ramp(x.abs(), 0.8, 0.3);
    // Above the inner brows the skin is gathered obliquely.
    let oblique = (y - 2.9 - 0.5 * (x.abs() - 1.5)) / 0.55 + 0.2 * noise(x, y, 22);
    let gathered = 0.06 * row(oblique) * pair(x, 1.8, 0.9) * plateau(y, 2.8, 3.9, 0.6);
    tall * (main + second + between) + root + root2 + gathered
}

/// Lines that fan out from the eyes' outer corners.
fn crows_feet(s: &Skin, depth: f64) -> f64 {
    let (dx, dy) = (s.site.across.abs() - 4.25, s.site.up - 0.05);
    if dx < 0.0 {
        return 0.0;
    }
    let (radius, angle) = ((dx * dx + dy * dy).sqrt(), dy.atan2(dx));
    // The lines curve: those above bend up, those below bend down.
    let bent =
        angle * (1.0 - 0.06 * radius) + 0.1 * noise(radius / 0.9, angle * 1.5, 31 + u32::from(s.p.x > 0.0));
    let phase = bent / 0.27 + 0.5;
    let length = 2.3 + 0.5 * noise(0.9 * phase, s.p.x.signum(), 32);
    let region = plateau(radius, 0.95, length - 0.7, 0.55) * ramp(angle.abs(), 1.15, 0.75);
    depth * region * broken(phase, radius / 0.8, 33) * row(phase)
}

/// The wrinkle from the nose's wing past the mouth's corner: the cheek rolls over it.
fn nasolabial(s: &Skin, depth: f64) -> f64 {
    let y = s.site.up;
    let u = y.clamp(-8.2, -2.8) + 5.2;
    let path = 2.8455 + u * (-0.6193 + u * (-0.0948 + u * (0.0362 + u * 0.0059)));
    let t = s.p.x.abs() - path + 0.05 * noise(y / 1.1, s.p.x.signum(), 41);
    let along = plateau(y, -6.0, -3.6, 1.3);
    let valley = (-((t / 0.2) * (t / 0.2) + 0.04).sqrt() * 1.2 + 0.24).exp();
    let crest = bell(t, 0.5, 0.42);
    let second = 0.3 * furrow(t - 0.95 - 0.1 * (y + 5.5), 0.17) * plateau(y, -6.4, -4.9, 0.7);
    depth * (along * (0.75 * crest - valley) + second)
}

/// Nasolabial wrinkles, crow's feet, and short lines beside the mouth's corners.
pub(crate) fn smile(s: &Skin) -> f64 {
    let (x, y) = (s.p.x.abs(), s.site.up);
    let dimple = 0.03 * furrow(x - 3.05 - 0.25 * (y + 6.5) * (y + 6.5), 0.12) * plateau(y, -6.9, -6.2, 0.45);
    let lower_lid = 0.05 * furrow(y + 0.95 - 0.1 * (x - 3.0) * (x - 3.0), 0.14) * plateau(x, 2.3, 4.1, 0.7);
    nasolabial(s, 0.15) + crows_feet(s, 0.085) + dimple + lower_lid
}

/// Crow's feet, lines below the lower lids, and oblique lines on the nose's sides.
pub(crate) fn squint(s: &Skin) -> f64 {
    let (x, y) = (s.p.x.abs(), s.site.up);
    let sag = 0.14 * (x - 3.0) * (x - 3.0) + 0.07 * noise(s.p.x / 0.9, y / 0.6, 51);
    let below = (-y - 0.42 + sag) / 0.33;
    let lower_lid = 0.06
        * row(below)
        * broken(below, s.p.x / 0.9, 52)
        * plateau(-y + sag, 0.62, 1.35, 0.3)
        * plateau(x, 2.0, 4.2, 0.6);
    let oblique = (y + 0.95 * x + 0.08 * noise(s.p.x / 0.5, y / 0.5, 53)) / 0.42
        + 0.25 * noise(s.p.x / 0.8, y / 0.9, 54);
    let bunny = 0.075
        * row(oblique)
        * broken(oblique, s.p.x / 0.5, 55)
        * plateau(x, 0.45, 1.25, 0.35)
        * plateau(y, -1.9, -0.6, 0.5);
    let root = 0.09 * furrow(y - 0.75 + 0.15 * x * x, 0.15) * ramp(x, 1.1, 0.4);
    lower_lid + bunny + root + crows_feet(s, 0.115) + nasolabial(s, 0.05)
}

/// Lines that radiate from the gathered lips, and a dimpled chin.
pub(crate) fn pucker(s: &Skin) -> f64 {
    let (x, y) = (s.p.x, s.site.up);
    let away = (y + 6.45).abs() - 0.3;
    let fan = x / (1.0 + 0.2 * away.max(0.0)) + 0.07 * noise(x / 0.8, y / 0.9, 61);
    let phase = (fan + 0.05 * noise(x / 0.35, 0.0, 62)) / 0.34;
    let upper = plateau(away, 0.15, 1.15, 0.35);
    let lower = plateau(away, 0.15, 0.95, 0.35);
    let reach = if s.site.above_mouth { upper } else { lower };
    let lines = 0.075 * row(phase) * broken(phase, away * 0.8, 63) * reach * ramp(x.abs(), 2.6, 1.5);
    let chin = plateau(y, -10.0, -8.9, 0.6) * ramp(x.abs(), 1.9, 0.9);
    // The coordinates are rotated, so that the noise's lattice does not show.
    let (u, v) = (0.8 * x + 0.6 * y, 0.8 * y - 0.6 * x);
    let lump = noise(u / 0.36, v / 0.36, 64) + 0.5 * noise(v / 0.21, u / 0.21, 65);
    let crease = 0.1 * furrow(y + 8.35 - 0.12 * x * x, 0.2) * ramp(x.abs(), 2.2, 1.2);
    lines + 0.055 * chin * lump + crease + nasolabial(s, 0.04)
}

/// Wrinkles under the jaw, a line below the lip, and long lines in the cheeks.
pub(crate) fn jaw_open(s: &Skin) -> f64 {
    let (x, y, side) = (s.p.x, s.site.up, s.site.across.abs());
    let phase = (y + 11.75 - 0.03 * x * x + 0.1 * noise(x / 1.6, y / 1.2, 71)) / 0.68;
    let neck =
        0.13 * row(phase) * broken(phase, x / 1.5, 72) * plateau(y, -13.4, -11.6, 0.7) * ramp(side, 7.2, 3.5);
    let chin = 0.09 * furrow(y + 8.4 - 0.1 * x * x, 0.18) * ramp(side, 2.3, 1.2);
    let cheek = 4.0 + 0.09 * (y + 6.0) * (y + 6.0);
    let long = furrow(side - cheek, 0.26) + 0.6 * furrow(side - cheek - 1.0, 0.24);
    0.06 * long * plateau(y + 0.2 * noise(x, y, 73), -6.9, -5.5, 1.3) + neck + chin + nasolabial(s, 0.06)
}
