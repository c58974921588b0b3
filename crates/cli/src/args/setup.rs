//! The setup: what is known of an actor and a capture session. Each item is an option of `prepare` and a key
//! of TAKE.toml.

use super::values::{
    FilterChoice, StepChoice, Stretch, UnitChoice, parse_pair, parse_pose, parse_rate, parse_region,
    parse_seconds, rate, seconds,
};
use rhytid::capture::{Axes, Edit, Settings, Step};
use rhytid::core::{input_file, rig_file};
use rhytid::formats::{Reach, named_file, tables};
use rhytid::playback::{CleanUp, FrameRange};
use rhytid::{Error, InputErrorKind, Result};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Each option is also a key of TAKE.toml, with `_` for `-`. Missing values are found.
#[derive(Debug, Clone, Default, PartialEq, clap::Args, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Setup {
    /// The raw take's frames per second [default: what the file says].
    #[arg(long, value_name = "N", value_parser = parse_rate)]
    #[serde(deserialize_with = "some_rate")]
    pub rate: Option<f64>,

    /// A handle whose marker has another label in the file; can be given many times.
    #[arg(long, value_name = "HANDLE=LABEL", value_parser = parse_pair)]
    #[serde(deserialize_with = "table")]
    pub map: Vec<(String, String)>,

    /// A table of handles and their markers' labels, as --write-markers wrote it; --map wins.
    #[arg(long, value_name = "TABLE.csv")]
    pub markers: Option<PathBuf>,

    /// The subject whose markers are the face's, such as Anna for labels like Anna:jaw00 [default: the only
    /// one whose labels are the handles'].
    #[arg(long, value_name = "NAME")]
    pub subject: Option<String>,

    /// The rigid markers, on a cap for example [default: markers of no handle that keep their distances and
    /// travel with the face].
    #[arg(long, value_name = "A,B,C", value_delimiter = ',')]
    pub rigid: Option<Vec<String>>,

    /// The file's unit [default: what the file says, or what fits the rig's size].
    #[arg(long, value_enum)]
    pub unit: Option<UnitChoice>,

    /// The file's axes that the mesh's x, y and z are, such as +x+z-y [default: those in which the actor
    /// looks where the rig looks].
    #[arg(long, value_name = "AXES", allow_hyphen_values = true)]
    #[serde(deserialize_with = "some_text")]
    pub axes: Option<Axes>,

    /// The neutral frames A to B-1, counted from 0 [default: the stillest half second nearest to the rest
    /// pose].
    #[arg(long, value_name = "A..B")]
    #[serde(deserialize_with = "some_text")]
    pub neutral: Option<FrameRange>,

    /// Steps to leave out; can be given many times.
    #[arg(long, value_enum, value_name = "STEP", value_delimiter = ',')]
    pub skip: Vec<StepChoice>,

    /// Flag gaps longer than this many seconds as lost [default: 2].
    #[arg(long, value_name = "S", value_parser = parse_seconds)]
    #[serde(deserialize_with = "some_seconds")]
    pub max_gap: Option<f64>,

    /// The markers' low-pass filter: its cut-off in Hz, or none [default: 12 where the take is noisy, else
    /// none].
    ///
    /// It runs both ways, without delay. By default it takes no more from a position than the noise that was
    /// measured in the take. A given cut-off removes everything faster.
    #[arg(long, value_name = "HZ|none", alias = "low-pass")]
    #[serde(alias = "low_pass", deserialize_with = "some_filter")]
    pub filter: Option<FilterChoice>,

    /// The cut-off of the head motion's low-pass filter in Hz [default: 8].
    #[arg(long, value_name = "HZ", value_parser = parse_rate)]
    #[serde(deserialize_with = "some_rate")]
    pub head_low_pass: Option<f64>,

    /// A frame in which the actor does what an example of the rig shows; can be given many times. These
    /// frames say how the actor's motion becomes the rig's, region by region.
    #[arg(long = "pose", value_name = "EXAMPLE=FRAME", value_parser = parse_pose)]
    #[serde(deserialize_with = "table")]
    pub poses: Vec<(String, usize)>,

    /// For `animate`: the gains of wrinkles about a handle or in a region, as `--detail-of`.
    #[arg(skip)]
    #[serde(deserialize_with = "gains")]
    pub detail: Vec<(String, f64)>,

    /// Exchange two markers' labels from frame FROM to TO-1; can be given many times, as can the next two.
    #[arg(long, value_name = "A,B:FROM..TO")]
    #[serde(deserialize_with = "texts")]
    pub swap: Vec<Stretch<2>>,

    /// Drop a marker's positions in frames FROM to TO-1, and fill them as a gap.
    #[arg(long, value_name = "LABEL:FROM..TO")]
    #[serde(deserialize_with = "texts")]
    pub drop: Vec<Stretch<1>>,

    /// Hold a marker in frames FROM to TO-1 where it was on the face.
    #[arg(long, value_name = "LABEL:FROM..TO")]
    #[serde(deserialize_with = "texts")]
    pub hold: Vec<Stretch<1>>,

    /// Keep a result that no face can have, with a warning in place of the error.
    #[arg(long)]
    pub force: bool,
}

impl Setup {
    /// Reads TAKE.toml.
    ///
    /// # Errors
    /// [`Error::Input`] names the line: no TOML, an unknown key, a value of the wrong type or out of its
    /// range; a table out of `reach`; [`Error::Io`].
    pub(crate) fn read(path: &Path, reach: Reach) -> Result<Self> {
        let bytes = input_file::read(path, input_file::LARGEST_TEXT)?;
        let wrong = |offset: usize, what: &str| {
            let line = 1 + bytes[..offset].iter().filter(|&&byte| byte == b'\n').count();
            Error::malformed(format!("{}, line {line}: {what}", path.display()))
                .of_kind(InputErrorKind::Malformed { line: Some(line) })
        };
        let text = std::str::from_utf8(&bytes)
            .map_err(|error| wrong(error.valid_up_to(), "is not UTF-8, expected a TOML file"))?;
        let mut setup: Self = toml::from_str(text).map_err(|error| {
            wrong(error.span().map_or(0, |span| span.start), &error.message().replace('\n', ", "))
        })?;
        // Relative to the file, as in a project.
        setup.markers = setup.markers.map(|table| named_file(path, &table, "markers", reach)).transpose()?;
        Ok(setup)
    }

    /// A hash of the setup in a file: of its text, and of the table of markers that it names.
    ///
    /// # Errors
    /// As [`Setup::read`]; [`Error::Io`].
    pub(crate) fn hash(path: &Path, reach: Reach) -> Result<String> {
        let setup = Self::read(path, reach)?;
        let mut hash = rig_file::hash(path)?;
        if let Some(table) = &setup.markers {
            hash.push_str(&rig_file::hash(table)?);
        }
        Ok(hash)
    }

    /// These values, and those of `other` where these are missing.
    pub(crate) fn or(mut self, other: Self) -> Self {
        let given: Vec<String> = self.map.iter().map(|(handle, _)| handle.clone()).collect();
        self.map.extend(other.map.into_iter().filter(|(handle, _)| !given.contains(handle)));
        self.skip.extend(other.skip);
        let given: Vec<String> = self.poses.iter().map(|(example, _)| example.clone()).collect();
        self.poses.extend(other.poses.into_iter().filter(|(example, _)| !given.contains(example)));
        self.swap.extend(other.swap);
        self.drop.extend(other.drop);
        self.hold.extend(other.hold);
        Self {
            rate: self.rate.or(other.rate),
            map: self.map,
            markers: self.markers.or(other.markers),
            subject: self.subject.or(other.subject),
            rigid: self.rigid.or(other.rigid),
            unit: self.unit.or(other.unit),
            axes: self.axes.or(other.axes),
            neutral: self.neutral.or(other.neutral),
            skip: self.skip,
            max_gap: self.max_gap.or(other.max_gap),
            filter: self.filter.or(other.filter),
            head_low_pass: self.head_low_pass.or(other.head_low_pass),
            poses: self.poses,
            detail: if self.detail.is_empty() { other.detail } else { self.detail },
            swap: self.swap,
            drop: self.drop,
            hold: self.hold,
            force: self.force || other.force,
        }
    }

    /// For the clean-up.
    ///
    /// # Errors
    /// [`Error::Input`] if a handle is given two markers, or the table of markers is wrong; [`Error::Io`].
    pub(crate) fn clean_up(&self) -> Result<CleanUp> {
        let mut markers = BTreeMap::new();
        for (i, (handle, label)) in self.map.iter().enumerate() {
            if let Some((first, _)) =
                self.map[..i].iter().find(|(other, known)| known == label && other != handle)
            {
                return Err(Error::conflict(format!(
                    "--map: the label “{label}” is given to two handles, “{first}” and “{handle}”; give it to one"
                )));
            }
            if markers.insert(handle.clone(), label.clone()).is_some() {
                return Err(Error::conflict(format!(
                    "--map: the handle “{handle}” is given two markers; give one"
                )));
            }
        }
        if let Some(table) = &self.markers {
            let pairs = tables::read_markers(table)?;
            let given: Vec<String> = markers.values().cloned().collect();
            let others = pairs
                .into_iter()
                .filter(|(handle, label)| !markers.contains_key(handle) && !given.contains(label));
            let others: Vec<(String, String)> = others.collect();
            markers.extend(others);
        }
        let defaults = Settings::default();
        let mut skip: BTreeSet<Step> = self.skip.iter().map(|step| (*step).into()).collect();
        let low_pass = match self.filter {
            Some(FilterChoice::LowPass(hz)) => Some(hz),
            Some(FilterChoice::None) => {
                skip.insert(Step::LowPass);
                None
            }
            None => None,
        };
        let swaps = self.swap.iter().map(|s| Edit::Swap(s.labels.clone(), s.range()));
        let drops = self.drop.iter().map(|s| Edit::Drop(s.labels[0].clone(), s.range()));
        let holds = self.hold.iter().map(|s| Edit::Hold(s.labels[0].clone(), s.range()));
        let edits = swaps.chain(drops).chain(holds).collect();
        let settings = Settings {
            markers,
            subject: self.subject.clone(),
            rigid: self.rigid.clone(),
            metres_per_unit: self.unit.map(UnitChoice::metres),
            axes: self.axes,
            neutral: self.neutral.map(|range| range.start.unwrap_or(0)..range.end.unwrap_or(usize::MAX)),
            skip,
            max_gap: self.max_gap.unwrap_or(defaults.max_gap),
            low_pass,
            head_low_pass: self.head_low_pass.unwrap_or(defaults.head_low_pass),
            poses: self.poses.iter().cloned().collect(),
            edits,
            fps: None,
            force: self.force,
        };
        Ok(CleanUp { rate: self.rate, settings, ..CleanUp::default() })
    }
}

fn some_rate<'de, D: Deserializer<'de>>(from: D) -> std::result::Result<Option<f64>, D::Error> {
    rate(f64::deserialize(from)?).map(Some).map_err(D::Error::custom)
}

fn some_seconds<'de, D: Deserializer<'de>>(from: D) -> std::result::Result<Option<f64>, D::Error> {
    seconds(f64::deserialize(from)?).map(Some).map_err(D::Error::custom)
}

fn some_text<'de, D: Deserializer<'de>, T: FromStr<Err: Display>>(
    from: D,
) -> std::result::Result<Option<T>, D::Error> {
    let text = String::deserialize(from)?;
    text.parse().map(Some).map_err(|error| D::Error::custom(format!("“{text}”: {error}")))
}

fn texts<'de, D: Deserializer<'de>, T: FromStr<Err: Display>>(
    from: D,
) -> std::result::Result<Vec<T>, D::Error> {
    let texts = Vec::<String>::deserialize(from)?;
    let parse = |text: String| text.parse().map_err(|error| D::Error::custom(format!("“{text}”: {error}")));
    texts.into_iter().map(parse).collect()
}

/// A number of Hz, or “none”.
fn some_filter<'de, D: Deserializer<'de>>(from: D) -> std::result::Result<Option<FilterChoice>, D::Error> {
    let text = match toml::Value::deserialize(from)? {
        toml::Value::String(text) => text,
        other => other.to_string(),
    };
    text.parse().map(Some).map_err(|error| D::Error::custom(format!("“{text}”: {error}")))
}

fn gains<'de, D: Deserializer<'de>>(from: D) -> std::result::Result<Vec<(String, f64)>, D::Error> {
    let gains: Vec<(String, f64)> = table(from)?;
    for (region, gain) in &gains {
        parse_region(&format!("{region}={gain}"))
            .map_err(|error| D::Error::custom(format!("“{region}”: {error}")))?;
    }
    Ok(gains)
}

fn table<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    from: D,
) -> std::result::Result<Vec<(String, T)>, D::Error> {
    Ok(BTreeMap::deserialize(from)?.into_iter().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Flags {
        #[command(flatten)]
        setup: Setup,
    }

    fn read(text: &str) -> Result<Setup> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("take.toml");
        std::fs::write(&path, text).unwrap();
        Setup::read(&path, Reach::Below)
    }

    #[test]
    fn a_file_says_what_flags_say() {
        let flags = "x --rate 120 --map chin=M12 --map brow=M7 --subject Anna --rigid cap0,cap1,cap2 --unit cm --axes +x+z-y --neutral 3..60 \
                     --skip swaps,head-low-pass --max-gap 1.5 --low-pass 12 --head-low-pass 6 --swap a,b:900..940 \
                     --drop A:chin:120.. --hold brow:0..9 --pose smile=512 --force";
        let mut flags = Flags::parse_from(flags.split_whitespace()).setup;
        flags.map.sort();
        let file = read(
            r#"
            rate = 120
            subject = "Anna"
            force = true
            rigid = ["cap0", "cap1", "cap2"]
            unit = "cm"
            axes = "+x+z-y"
            neutral = "3..60"
            skip = ["swaps", "head-low-pass"]
            max_gap = 1.5
            filter = 12
            head_low_pass = 6.0
            swap = ["a,b:900..940"]
            drop = ["A:chin:120.."]
            hold = ["brow:0..9"]
            [map]
            chin = "M12"
            brow = "M7"
            [poses]
            smile = 512
            "#,
        );
        assert_eq!(file.unwrap(), flags);
        assert_eq!(read("").unwrap(), Setup::default());
    }

    #[test]
    fn flags_win() {
        let file = read("rate = 30\nunit = \"mm\"\nskip = [\"swaps\"]\n[map]\na = \"1\"\nb = \"2\"").unwrap();
        let flags = Flags::parse_from("x --rate 60 --map a=9 --skip align".split(' ')).setup.or(file);
        assert_eq!((flags.rate, flags.unit), (Some(60.0), Some(UnitChoice::Mm)));
        assert_eq!(flags.skip, [StepChoice::Align, StepChoice::Swaps]);
        let settings = flags.clean_up().unwrap().settings;
        assert_eq!(settings.low_pass, None);
        assert_eq!(
            settings.markers,
            BTreeMap::from([("a", "9"), ("b", "2")].map(|(a, b)| (a.into(), b.into())))
        );
    }

    #[test]
    fn mistakes_are_told_with_their_line() {
        for (text, expected) in [
            ("rate = 30\nunits = \"mm\"", "line 2: unknown field `units`"),
            ("\n\nrate = 0", "line 3: expected a number per second"),
            ("rate = \"fast\"", "line 1: invalid type"),
            ("unit = \"furlong\"", "line 1: unknown variant `furlong`"),
            ("axes = \"+x+y\"", "line 1: “+x+y”"),
            ("neutral = \"9..3\"", "line 1: “9..3”: it has no frame"),
            ("skip = [\"all\"]", "line 1: unknown variant `all`"),
            ("max_gap = -1", "line 1: expected seconds"),
            ("filter = \"some\"", "line 1: “some”: expected none, or a cut-off in Hz"),
            ("filter = -3", "line 1: “-3”: expected none"),
            ("drop = [\"chin\"]", "line 1: “chin”: expected LABEL:A..B"),
            ("swap = [\"a:1..2\"]", "line 1: “a:1..2”: expected A,B:FROM..TO"),
            ("[map]\nchin = 12", "line 2: invalid type"),
            ("rate =", "line 1: "),
        ] {
            let message = read(text).unwrap_err().to_string();
            assert!(message.contains(&format!("take.toml, {expected}")), "{message}");
        }
    }
}
