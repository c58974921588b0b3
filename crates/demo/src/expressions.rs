//! The six expressions: the large motions of the skin by muscles, region by region. Their wrinkles are in
//! `wrinkles`.
use crate::curve::{bell, pair, ramp};
use crate::shape::{EYE_LINE, Shape};
use crate::skin::Skin;
use crate::wrinkles;
use glam::{DQuat, DVec3};

/// One expression at its apex.
#[derive(Debug)]
pub(crate) struct Expression {
    /// Its name.
    pub name: &'static str,
    motion: fn(&Shape, &Skin) -> DVec3,
    wrinkles: fn(&Skin) -> f64,
}

/// All of them.
pub(crate) const EXPRESSIONS: [Expression; 6] = [
    Expression { name: "brow_raise", motion: brow_raise, wrinkles: wrinkles::brow_raise },
    Expression { name: "frown", motion: frown, wrinkles: wrinkles::frown },
    Expression { name: "smile", motion: smile, wrinkles: wrinkles::smile },
    Expression { name: "squint", motion: squint, wrinkles: wrinkles::squint },
    Expression { name: "pucker", motion: pucker, wrinkles: wrinkles::pucker },
    Expression { name: "jaw_open", motion: jaw_open, wrinkles: wrinkles::jaw_open },
];

impl Expression {
    /// How far a point of the skin moves, in centimetres: the large motion and the wrinkles.
    pub(crate) fn displacement(&self, shape: &Shape, skin: &Skin) -> DVec3 {
        skin.inside * ((self.motion)(shape, skin) + skin.n * (self.wrinkles)(skin))
    }
}

/// Lowers the upper lids and raises the lower ones; 1 shuts the eyes.
fn close_lids(shape: &Shape, skin: &Skin, amount: f64) -> DVec3 {
    let side = skin.site.across.abs();
    let (upper, lower) = shape.eye.rims(side);
    // The lids meet below the middle, since the upper one makes most of the way.
    let meeting = 0.65 * lower;
    let way = if skin.site.above_eyes { -(upper + meeting) } else { lower - meeting };
    let fade = ramp((skin.site.up - EYE_LINE).abs(), 1.7, 0.05);
    let way = way * amount * fade;
    // A lid slides over the ball, which is nearer the front in the middle.
    let bulge = 0.3 * pair(skin.p.x, 3.04, 1.0) * bell(skin.p.y, 0.9, 0.5) + 0.12 * way.abs();
    DVec3::new(0.0, way, amount * bulge)
}

fn brow_raise(shape: &Shape, s: &Skin) -> DVec3 {
    let y = s.site.up;
    let across = ramp(s.site.across.abs(), 7.8, 4.2);
    let lift = 0.9 * ramp(y, 0.3, 2.6) * ramp(y, 7.4, 2.2) * across;
    let lid = if s.site.above_eyes { 0.2 * shape.eye.rims(s.site.across).0 * ramp(y, 0.9, 0.0) } else { 0.0 };
    DVec3::new(0.0, lift, -0.3 * lift * ramp(y, 3.0, 7.0)) + DVec3::Y * (lid * across)
}

fn frown(shape: &Shape, s: &Skin) -> DVec3 {
    let inner = s.near(1.7, 2.2, 1.5, 1.15);
    let outer = s.near(4.0, 2.4, 1.6, 1.0);
    let middle = s.near(0.0, 1.9, 1.2, 1.2);
    let pull = DVec3::new(-0.5 * s.side, -0.55, 0.0) * inner
        + DVec3::new(-0.3 * s.side, -0.25, 0.0) * outer
        + DVec3::new(0.0, -0.3, 0.0) * middle;
    let bulge = DVec3::Z * (0.22 * s.near(1.1, 1.7, 0.9, 0.7));
    let lips = DVec3::Y * (-0.16 * s.near(2.8, -6.5, 1.6, 1.2));
    pull + bulge + lips + close_lids(shape, s, 0.22)
}

fn smile(shape: &Shape, s: &Skin) -> DVec3 {
    let corner = s.near(3.2, -6.3, 1.9, 1.5);
    let lip = s.near(0.0, -6.4, 2.3, 1.0);
    let cheek = s.near(3.8, -3.3, 1.8, 1.7);
    let pull = DVec3::new(0.8 * s.side, 0.62, -0.45) * corner;
    let parted = 0.1 * lip * (s.from_mouth / 1.5).tanh();
    let flatten = DVec3::new(0.0, 0.1 + parted, -0.18) * lip;
    let raise = DVec3::new(0.16 * s.side, 0.55, 0.3) * cheek;
    let nostril = DVec3::new(0.12 * s.side, 0.12, -0.03) * s.near(1.4, -3.9, 0.8, 0.8);
    let chin = DVec3::new(0.0, 0.1, -0.05) * s.near(0.0, -9.0, 2.5, 1.5);
    let lower_lid = if s.site.above_eyes { 0.0 } else { close_lids(shape, s, 1.0).y };
    pull + flatten + raise + nostril + chin + DVec3::Y * lower_lid
}

fn squint(shape: &Shape, s: &Skin) -> DVec3 {
    let brow = DVec3::new(-0.12 * s.side, -0.5, 0.1) * s.near(2.9, 2.3, 2.4, 1.1);
    let cheek = DVec3::new(0.0, 0.5, 0.18) * s.near(3.6, -2.3, 2.0, 1.5);
    let temple = DVec3::new(-0.3 * s.side, 0.0, 0.1) * s.near(6.0, 0.1, 1.5, 1.5);
    let nose = DVec3::new(0.0, 0.3, 0.05) * s.near(1.1, -2.7, 1.1, 1.6);
    let lip = DVec3::new(0.1 * s.side, 0.28, 0.0) * s.near(1.9, -5.6, 1.6, 1.0);
    let lip = lip * ramp(s.from_mouth, -1.5, 1.5);
    brow + cheek + temple + nose + lip + close_lids(shape, s, 0.86)
}

fn pucker(_: &Shape, s: &Skin) -> DVec3 {
    let lips = s.near(0.0, -6.5, 4.2, 2.0);
    let gather = DVec3::new(-0.48 * s.p.x, 0.0, 0.0) * lips;
    let forward = DVec3::Z * (0.8 * s.near(0.0, -6.5, 2.3, 1.5));
    let parted = DVec3::Y * (0.1 * s.near(0.0, -6.45, 1.1, 0.8) * (s.from_mouth / 1.2).tanh());
    let hollow = -s.n * (0.22 * s.near(4.4, -5.6, 1.3, 1.5));
    let chin = DVec3::new(0.0, 0.35, 0.08) * s.near(0.0, -9.0, 1.9, 1.2);
    gather + forward + parted + hollow + chin
}

fn jaw_open(_: &Shape, s: &Skin) -> DVec3 {
    /// Height and depth of the axis through the jaw's joints.
    const JOINT: DVec3 = DVec3::new(0.0, -1.8, -7.2);
    /// How far the jaw turns, in radians.
    const ANGLE: f64 = 0.21;
    /// How far the joints slide forward meanwhile.
    const SLIDE: DVec3 = DVec3::new(0.0, 0.0, 0.5);
    let jaw = ramp(s.from_mouth, 3.0, -3.0) * ramp(s.site.up, -16.0, -9.6);
    let turned = DQuat::from_rotation_x(ANGLE * jaw) * (s.p - JOINT) + JOINT + jaw * SLIDE - s.p;
    let corner = DVec3::new(-0.3 * s.side, 0.0, -0.15) * s.near(3.0, -6.5, 1.6, 1.6);
    let hollow = -s.n * (0.22 * s.near(4.8, -5.2, 1.3, 1.7));
    let upper_lip = DVec3::new(0.0, 0.12, -0.05) * s.near(0.0, -5.9, 1.6, 0.8) * ramp(s.from_mouth, 0.0, 2.0);
    turned + corner + hollow + upper_lip
}
