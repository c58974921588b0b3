//! A rig file with one changed tensor: other values, another shape, another name, or missing. Such files get
//! past the header, which plain bytes hardly do.
#![no_main]
use libfuzzer_sys::{fuzz_mutator, fuzz_target};
use mutation::mutate;
use rhytid_core::{Error, Rig, rig_file};
use safetensors::tensor::{Dtype, SafeTensors, TensorView, serialize};

#[path = "mutation/mod.rs"]
mod mutation;

fuzz_target!(|bytes: &[u8]| match rig_file::decode(bytes, "fuzz") {
    Ok(rig) => drop(Rig::new(rig.into_parts()).expect("a rig that was read is sound")),
    Err(Error::Input(sentence)) => assert!(sentence.sentence().starts_with("fuzz"), "{sentence}"),
    Err(other) => panic!("expected an input error, found {other:?}"),
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    mutation::replace(changed(&data[..size], seed as usize), data, size, max_size)
});

/// The file with one tensor changed, or the metadata.
fn changed(file: &[u8], seed: usize) -> Option<Vec<u8>> {
    let (_, metadata) = SafeTensors::read_metadata(file).ok()?;
    let mut metadata = metadata.metadata().clone()?;
    let file = SafeTensors::deserialize(file).ok()?;
    let mut tensors: Vec<(String, Dtype, Vec<usize>, Vec<u8>)> = file
        .tensors()
        .into_iter()
        .map(|(name, view)| (name, view.dtype(), view.shape().to_vec(), view.data().to_vec()))
        .collect();
    // The tensors come in any order.
    tensors.sort();
    let chosen = seed % (tensors.len() + 1);
    let seed = seed / (tensors.len() + 1);
    if chosen == tensors.len() {
        let text = metadata.values_mut().next()?;
        let mut bytes = std::mem::take(text).into_bytes();
        mutate(&mut bytes);
        *text = String::from_utf8_lossy(&bytes).into_owned();
    } else {
        let tensor = &mut tensors[chosen];
        match seed % 8 {
            0 => drop(tensors.remove(chosen)),
            1 => tensor.2.reverse(),
            2 => tensor.2 = vec![tensor.2.iter().product()],
            3 => tensor.1 = if tensor.1 == Dtype::F32 { Dtype::U32 } else { Dtype::F32 },
            4 => tensor.0.push('s'),
            _ => {
                let size = tensor.3.len();
                mutate(&mut tensor.3);
                tensor.3.resize(size, 0);
                if seed % 8 == 5 {
                    // One row less or more of everything.
                    let line = size / tensor.2.first().filter(|&&lines| lines > 0)?;
                    tensor.2[0] += 1;
                    tensor.3.resize(size + line, 0);
                }
            }
        }
    }
    let views: Option<Vec<_>> = tensors
        .iter()
        .map(|(name, dtype, shape, bytes)| Some((name, TensorView::new(*dtype, shape.clone(), bytes).ok()?)))
        .collect();
    serialize(views?, Some(metadata)).ok()
}
