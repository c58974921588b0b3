//! Crate files built to take memory or time without end.
use super::damaged::read_all;
use crate::animation::Random;
use rhytid_formats::usd::layer::{Attribute, Layer, Prim, Property, Specifier, Value};
use rhytid_formats::usd::write::{Encoding, LayerWriter};

fn prim(name: &str, children: Vec<Prim>) -> Prim {
    let (metadata, properties) = (Vec::new(), Vec::new());
    let (specifier, type_name) = (Specifier::Def, String::new());
    Prim { specifier, type_name, name: name.into(), metadata, properties, children }
}

fn ints(name: &str, ints: Vec<i32>) -> Property {
    Property::Attribute(Attribute {
        name: name.into(),
        type_name: "int[]".into(),
        uniform: false,
        metadata: Vec::new(),
        default: Some(Value::Ints(ints)),
        connections: Vec::new(),
        samples: None,
    })
}

fn crate_file(prims: Vec<Prim>) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.usd");
    let layer = Layer { metadata: Vec::new(), prims };
    LayerWriter::create(&path, Encoding::Crate, &layer).unwrap().finish().unwrap();
    std::fs::read(path).unwrap()
}

/// `numbers` as a crate file compresses them, after the length: each difference in four bytes.
fn compressed(numbers: &[i32]) -> Vec<u8> {
    let mut encoded = vec![0; 4];
    encoded.extend(std::iter::repeat_n(0xff, numbers.len().div_ceil(4)));
    let mut last = 0;
    for &number in numbers {
        encoded.extend(i32::to_le_bytes(number - last));
        last = number;
    }
    let block = [vec![0], lz4_flex::block::compress(&encoded)].concat();
    [(block.len() as u64).to_le_bytes().to_vec(), block].concat()
}

/// The file with another tree of paths, `count` of them.
fn with_paths(mut file: Vec<u8>, count: u64, indices: &[i32], names: &[i32], jumps: &[i32]) -> Vec<u8> {
    let start = file.len() as u64;
    file.extend(count.to_le_bytes());
    file.extend((indices.len() as u64).to_le_bytes());
    file.extend([indices, names, jumps].into_iter().flat_map(compressed));
    let size = file.len() as u64 - start;
    let contents = u64::from_le_bytes(file[16..24].try_into().unwrap()) as usize;
    let name = file[contents..].windows(6).position(|name| name == b"PATHS\0").unwrap();
    let at = contents + name + 16;
    file[at..at + 8].copy_from_slice(&start.to_le_bytes());
    file[at + 8..at + 16].copy_from_slice(&size.to_le_bytes());
    file
}

#[test]
fn few_bytes_do_not_become_many() {
    // Stored once, 256 times 4 MB when decoded.
    let zeros = |i: usize| ints(&format!("zeros{i}"), vec![0; 1 << 20]);
    let few = Prim { properties: (0..4).map(zeros).collect(), ..prim("a", Vec::new()) };
    let many = Prim { properties: (0..256).map(zeros).collect(), ..few.clone() };
    assert_eq!(read_all(&crate_file(vec![few])), None);
    let file = crate_file(vec![many]);
    assert!(file.len() < 100_000, "{} bytes", file.len());
    let message = read_all(&file).unwrap();
    assert!(message.contains("far larger together than a file of its size can hold"), "{message}");
}

/// One long list, which all prims name, of things to be taken away: nothing is kept of it, and yet it would
/// be read for each.
#[test]
fn lists_that_are_passed_over_are_counted() {
    let listed = |i: usize| Prim {
        metadata: vec![("apiSchemas".into(), Value::PrependedTokens(vec!["Api".into(); 3]))],
        ..prim(&format!("p{i}"), Vec::new())
    };
    let mut random = Random(1);
    let behind = ints("behind", (0..40_000).map(|_| random.below(1 << 31) as i32).collect());
    let mut prims: Vec<Prim> = (0..3_000).map(listed).collect();
    prims.push(Prim { properties: vec![behind], ..prim("last", Vec::new()) });
    let mut file = crate_file(prims);
    assert_eq!(read_all(&file), None);
    // It becomes longer than it is, so that what is stored behind it would be listed too.
    let [prepended, deleted, three] = [1 << 5, 1 << 3, 3];
    let head = [&[prepended, three][..], &[0; 7]].concat();
    let at = file.windows(head.len()).position(|bytes| bytes == head).unwrap();
    file[at] = deleted;
    assert_eq!(read_all(&file), None);
    file[at + 1..at + 9].copy_from_slice(&30_000_u64.to_le_bytes());
    let message = read_all(&file).unwrap();
    assert!(message.contains("far larger together"), "{message}");
}

#[test]
fn paths_that_go_in_circles_are_refused() {
    let file = crate_file(vec![prim("a", vec![prim("b", Vec::new())])]);
    let tree = |indices: &[i32], jumps: &[i32]| {
        let count = indices.len().max(3) as u64;
        read_all(&with_paths(file.clone(), count, indices, indices, jumps)).unwrap()
    };
    // Below the root is `a`, and below that
    for (indices, jumps, expected) in [
        // the root,
        ([0, 1, 0], [-1, -1, -2], "entry 2 names a path that another one names"),
        // `a` itself,
        ([0, 1, 1], [-1, -1, -2], "entry 2 names a path that another one names"),
        // what is beside it as well,
        ([0, 1, 2], [-1, 1, -2], "entry 2 names a path that another one names"),
        // something beyond the end, or before.
        ([0, 1, 2], [-1, -1, -1], "entry 3 is referred to and not there"),
        ([0, 1, 2], [-1, -3, -2], "entry 1 has a jump below −2"),
    ] {
        let message = tree(&indices, &jumps);
        assert!(message.contains(expected), "“{message}” lacks “{expected}”");
    }
    // Each entry is below the one before and beside it: if none were refused, 2⁶⁰ visits.
    let indices: Vec<i32> = (0..61).collect();
    let jumps: Vec<i32> = (0..61).map(|i| if i < 60 { 1 } else { -2 }).collect();
    let message = tree(&indices, &jumps);
    assert!(message.contains("entry 60 names a path that another one names"), "{message}");
}
