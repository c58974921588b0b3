//! The values of attributes at the time that is wanted.

use rhytid_core::{Error, InputErrorKind, Result};
use rhytid_usd::layer::{Prim, Value};
use rhytid_usd::read::{Samples, attribute};

/// Reads values.
pub(super) struct Values<'a> {
    pub(super) samples: Box<dyn Samples>,
    /// The time code. `None`: values without a time, else the first sample.
    pub(super) time: Option<f64>,
    /// Whether a value that changes was read at the time.
    pub(super) used_time: bool,
    /// The file, for messages.
    pub(super) name: &'a str,
}

impl Values<'_> {
    /// The value of the attribute `name`; `None` if there is none.
    ///
    /// Between two samples, vectors and numbers are interpolated linearly, as USD does.
    pub(super) fn get(&mut self, prim: &Prim, name: &str) -> Result<Option<Value>> {
        let Some(found) = attribute(prim, name) else { return Ok(None) };
        let Some(number) = found.samples.filter(|number| !self.samples.times(*number).is_empty()) else {
            return Ok(found.default.clone());
        };
        let Some(time) = self.time else {
            return match &found.default {
                Some(value) => Ok(Some(value.clone())),
                None => self.samples.read(number, 0).map(Some),
            };
        };
        self.used_time = true;
        let times = self.samples.times(number);
        let after = times.partition_point(|t| *t <= time);
        let (before, next) = (after.saturating_sub(1), after.min(times.len() - 1));
        let share = match times[next] - times[before] {
            0.0 => 0.0,
            step => ((time - times[before]) / step).clamp(0.0, 1.0),
        };
        let value = self.samples.read(number, before)?;
        if share == 0.0 || next == before {
            return Ok(Some(value));
        }
        let next = self.samples.read(number, next)?;
        Ok(Some(between(value, &next, share)))
    }

    /// Vectors of three numbers, one for each point.
    pub(super) fn vectors(&mut self, prim: &Prim, name: &str) -> Result<Option<Vec<[f64; 3]>>> {
        Ok(match self.get(prim, name)? {
            Some(Value::Float3s(vectors)) => Some(vectors.iter().map(|v| v.map(f64::from)).collect()),
            Some(Value::Double3s(vectors)) => Some(vectors),
            _ => None,
        })
    }

    /// Whole numbers, none of them below 0.
    pub(super) fn indices(&mut self, prim: &Prim, path: &str, name: &str) -> Result<Option<Vec<u32>>> {
        let Some(Value::Ints(numbers)) = self.get(prim, name)? else { return Ok(None) };
        let positive: Result<Vec<u32>, _> = numbers.into_iter().map(u32::try_from).collect();
        match positive {
            Ok(numbers) => Ok(Some(numbers)),
            Err(_) => Err(self.wrong(path, &format!("has a negative number in {name}; export it again"))),
        }
    }

    /// An error about the prim at `path`.
    pub(super) fn wrong(&self, path: &str, what: &str) -> Error {
        Error::malformed(format!("{}: the prim {path} {what}", self.name))
            .of_kind(InputErrorKind::Malformed { line: None })
    }
}

/// A value between two samples; `a` where their types are not interpolated.
fn between(a: Value, b: &Value, share: f64) -> Value {
    let mix = |a: f64, b: f64| a + share * (b - a);
    let short = |a: f32, b: f32| mix(a.into(), b.into()) as f32;
    match (a, b) {
        (Value::Float(a), Value::Float(b)) => Value::Float(short(a, *b)),
        (Value::Double(a), Value::Double(b)) => Value::Double(mix(a, *b)),
        (Value::Floats(a), Value::Floats(b)) if a.len() == b.len() => {
            Value::Floats(a.iter().zip(b).map(|(a, b)| short(*a, *b)).collect())
        }
        (Value::Float3(a), Value::Float3(b)) => Value::Float3([0, 1, 2].map(|c| short(a[c], b[c]))),
        (Value::Double3(a), Value::Double3(b)) => Value::Double3([0, 1, 2].map(|c| mix(a[c], b[c]))),
        (Value::Float3s(a), Value::Float3s(b)) if a.len() == b.len() => {
            Value::Float3s(a.iter().zip(b).map(|(a, b)| [0, 1, 2].map(|c| short(a[c], b[c]))).collect())
        }
        (Value::Double3s(a), Value::Double3s(b)) if a.len() == b.len() => {
            Value::Double3s(a.iter().zip(b).map(|(a, b)| [0, 1, 2].map(|c| mix(a[c], b[c]))).collect())
        }
        (Value::Matrix4d(a), Value::Matrix4d(b)) => {
            Value::Matrix4d([0, 1, 2, 3].map(|r| [0, 1, 2, 3].map(|c| mix(a[r][c], b[r][c]))))
        }
        (a, _) => a,
    }
}
