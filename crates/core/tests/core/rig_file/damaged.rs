//! A file that is damaged anywhere is refused, or is a rig.

use super::{BYTES, assemble, parse, refused};
use proptest::prelude::*;
use rhytid_core::{Error, Rig, rig_file};

/// Reads damaged bytes. They must be refused as input, or give a rig that passes [`Rig::new`].
fn survives(bytes: &[u8]) -> Result<(), TestCaseError> {
    match rig_file::decode(bytes, "face.safetensors") {
        Ok(rig) => {
            let again = Rig::new(rig.clone().into_parts());
            again.map_err(|e| TestCaseError::fail(e.to_string()))?;
            let bytes = rig_file::encode(&rig).map_err(|e| TestCaseError::fail(e.to_string()))?;
            prop_assert_eq!(rig_file::decode(&bytes, "again").unwrap(), rig);
        }
        Err(Error::Input(message)) => {
            prop_assert!(message.sentence().starts_with("face.safetensors: "), "{message}");
        }
        Err(other) => prop_assert!(false, "{other:?}"),
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn damaged_bytes(flips in prop::collection::vec((any::<prop::sample::Index>(), 1u8..), 1..9)) {
        let mut bytes = BYTES.clone();
        for (at, mask) in flips {
            bytes[at.index(BYTES.len())] ^= mask;
        }
        survives(&bytes)?;
    }

    /// Damage behind a header that is whole, where it is hardest to find.
    #[test]
    fn damaged_arrays(words in prop::collection::vec((any::<prop::sample::Index>(), 0u32..30), 1..4)) {
        let (header, arrays) = parse(&BYTES);
        let mut arrays = arrays.to_vec();
        for (at, word) in words {
            let start = 4 * at.index(arrays.len() / 4);
            arrays[start..][..4].copy_from_slice(&word.to_le_bytes());
        }
        survives(&assemble(&header, &arrays))?;
    }

    #[test]
    fn garbage(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        refused(&bytes, &[]);
    }
}
