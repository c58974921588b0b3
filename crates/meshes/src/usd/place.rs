//! Where a prim's transforms place it: the operations of `xformOpOrder`.

use super::values::Values;
use glam::{DMat4, DQuat, DVec3};
use rhytid_core::Result;
use rhytid_usd::layer::{Prim, Value};

/// A prim's own transform.
pub(super) struct Local {
    /// From the prim's space to that of its parent, for columns.
    pub(super) matrix: DMat4,
    /// Whether the parents' transforms do not count.
    pub(super) resets: bool,
}

/// The transform of the prim at `path`. The first operation is the outermost.
pub(super) fn local(prim: &Prim, path: &str, values: &mut Values<'_>) -> Result<Local> {
    let mut local = Local { matrix: DMat4::IDENTITY, resets: false };
    let Some(Value::Tokens(order)) = values.get(prim, "xformOpOrder")? else { return Ok(local) };
    for token in &order {
        if token == "!resetXformStack!" {
            local = Local { matrix: DMat4::IDENTITY, resets: true };
            continue;
        }
        let (name, is_inverse) = match token.strip_prefix("!invert!") {
            Some(name) => (name, true),
            None => (token.as_str(), false),
        };
        let value = values.get(prim, name)?;
        let kind = name.split(':').nth(1).unwrap_or_default();
        let matrix = value.as_ref().and_then(|value| operation(kind, value)).ok_or_else(|| {
            values
                .wrong(path, &format!("has the transform {name} without a value that fits; export it again"))
        })?;
        if is_inverse && matrix.determinant() == 0.0 {
            return Err(values.wrong(path, &format!("inverts {name}, which has no inverse; export it again")));
        }
        local.matrix *= if is_inverse { matrix.inverse() } else { matrix };
    }
    Ok(local)
}

/// The matrix of an operation, for columns; `None` if the value does not fit.
fn operation(kind: &str, value: &Value) -> Option<DMat4> {
    let vector = match value {
        Value::Float3(vector) => Some(DVec3::from_array(vector.map(f64::from))),
        Value::Double3(vector) => Some(DVec3::from_array(*vector)),
        _ => None,
    };
    let number = match value {
        Value::Float(number) => Some(f64::from(*number)),
        Value::Double(number) => Some(*number),
        _ => None,
    };
    let axis = |name: &str| match name {
        "X" => Some(DVec3::X),
        "Y" => Some(DVec3::Y),
        "Z" => Some(DVec3::Z),
        _ => None,
    };
    Some(match kind {
        "transform" => match value {
            // USD's vectors are rows.
            Value::Matrix4d(rows) => DMat4::from_cols_array_2d(rows),
            _ => return None,
        },
        "translate" => DMat4::from_translation(vector?),
        "scale" => DMat4::from_scale(vector?),
        "orient" => match value {
            Value::Quatd([real, i, j, k]) => {
                DMat4::from_quat(DQuat::from_xyzw(*i, *j, *k, *real).normalize())
            }
            _ => return None,
        },
        _ => {
            if let Some(axes) = kind.strip_prefix("rotate").filter(|axes| axes.len() == 3) {
                // The first axis is turned about first.
                let mut matrix = DMat4::IDENTITY;
                for name in axes.chars() {
                    let about = axis(&name.to_string())?;
                    let angle = about.dot(vector?).to_radians();
                    matrix = DMat4::from_axis_angle(about, angle) * matrix;
                }
                return Some(matrix);
            }
            let along = axis(kind.get(kind.len().checked_sub(1)?..)?)?;
            match &kind[..kind.len() - 1] {
                "rotate" => DMat4::from_axis_angle(along, number?.to_radians()),
                "translate" => DMat4::from_translation(along * number?),
                "scale" => DMat4::from_scale(DVec3::ONE + along * (number? - 1.0)),
                _ => return None,
            }
        }
    })
}
