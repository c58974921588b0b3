//! Paths of prims in USD.

use rhytid_core::Error;
use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

/// The path of a prim, such as `/char/anna/face`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PrimPath(Vec<String>);

impl PrimPath {
    /// The names from the root of the layer on; at least one.
    pub fn names(&self) -> &[String] {
        &self.0
    }
}

/// Whether a prim may have this name in every version of USD: ASCII letters, digits and underscores, not
/// beginning with a digit.
pub fn is_prim_name(name: &str) -> bool {
    let is_plain = name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
    is_plain && name.bytes().next().is_some_and(|first| !first.is_ascii_digit())
}

impl FromStr for PrimPath {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let names: Vec<String> = text.strip_prefix('/').unwrap_or("").split('/').map(String::from).collect();
        if names.iter().all(|name| is_prim_name(name)) {
            return Ok(Self(names));
        }
        Err(Error::bad_path(format!(
            "the prim path is “{text}”, expected a path such as /char/anna/face: each name has ASCII letters, digits \
             and underscores, and does not begin with a digit"
        )))
    }
}

impl Display for PrimPath {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|name| write!(f, "/{name}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_every_usd_reads_is_a_path() {
        for good in ["/face", "/char/anna_2/_face"] {
            assert_eq!(good.parse::<PrimPath>().unwrap().to_string(), good);
        }
        for bad in
            ["", "/", "face", "/face/", "/a//b", "/2nd", "/Zoë", "/a b", "/a.points", "/a{v=1}b", "../a"]
        {
            let message = bad.parse::<PrimPath>().unwrap_err().to_string();
            assert!(
                message.contains(&format!("“{bad}”, expected a path such as /char/anna/face")),
                "{message}"
            );
        }
    }
}
