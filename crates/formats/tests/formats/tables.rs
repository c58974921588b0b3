//! The tables of handles and strain edges: what is read, and what every mistake is called.
use proptest::prelude::*;
use rhytid_core::{Error, HandleId, Handles, Result, SurfacePoint, VertexId};
use rhytid_formats::tables::{
    decode_handles, decode_strain_edges, read_handles, read_strain_edges, write_handles,
};
use std::collections::HashSet;
use std::path::Path;

fn handles(text: &str) -> Result<Handles> {
    decode_handles(text.as_bytes(), "markers.csv")
}

/// A vertex, or a point with any weights.
fn point() -> impl Strategy<Value = SurfacePoint> {
    let inside = (any::<[u32; 3]>(), [1e-3..1.0, 0.0..1.0, 0.0..1.0]);
    let inside = inside.prop_filter_map("weights of a point", |(corners, weights)| {
        SurfacePoint::new(corners.map(VertexId), weights)
    });
    prop_oneof![any::<u32>().prop_map(|v| VertexId(v).into()), inside]
}

fn labels() -> Vec<String> {
    ["brow_left", "brow_right", "chin", "nose"].map(str::to_owned).to_vec()
}

fn edges(text: &str) -> Result<Vec<[u32; 2]>> {
    let edges = decode_strain_edges(text.as_bytes(), "edges.csv", &labels())?;
    Ok(edges.into_iter().map(|pair| pair.map(|h| h.0)).collect())
}

/// The sentence of an input error.
fn sentence<T: std::fmt::Debug>(result: Result<T>) -> String {
    match result {
        Err(Error::Input(sentence)) => sentence.to_string(),
        other => panic!("expected an input error, found {other:?}"),
    }
}

fn abc() -> Handles {
    Handles {
        labels: ["a", "b b", "ü"].map(str::to_owned).to_vec(),
        points: [7, 0, 4_294_967_295].map(|v| VertexId(v).into()).to_vec(),
    }
}

#[test]
fn handles_of_every_style_are_the_same() {
    for text in [
        "label,vertex\na,7\nb b,0\nü,4294967295\n",
        "label,vertex\na,7\nb b,0\nü,4294967295",
        "vertex,label\n7,a\n0,b b\n4294967295,ü\n",
        "\u{feff}label,vertex\r\na,7\r\nb b,0\r\nü,4294967295\r\n",
        "label,vertex\ra,7\rb b,0\rü,4294967295\r",
        " label ,\tvertex\n\n  a , 7 \n\n \nb b,0\n\"ü\",\"4294967295\"\n\n",
    ] {
        assert_eq!(handles(text).unwrap(), abc(), "{text:?}");
    }
}

#[test]
fn a_handle_may_be_inside_a_triangle() {
    let text = "weight_3,label,vertex,vertex_2,vertex_3,weight,weight_2,distance_mm\n\
                0.25,a,7,9,8,0.5,0.25,1.5\n,b,3,,,,,0\n0.333,c,1,2,4,0.333,0.333,\n";
    let point = |corners: [u32; 3], weights| SurfacePoint::new(corners.map(VertexId), weights).unwrap();
    let expected = [point([7, 9, 8], [0.5, 0.25, 0.25]), VertexId(3).into(), point([1, 2, 4], [1.0; 3])];
    let found = handles(text).unwrap().points;
    assert_eq!(found[..2], expected[..2]);
    assert_eq!(found[2].triangle(), expected[2].triangle());
    let apart = (0..3).map(|i| (found[2].weights()[i] - expected[2].weights()[i]).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-6);
}

#[test]
fn a_vertex_may_occur_twice() {
    assert_eq!(handles("label,vertex\na,3\nb,3\n").unwrap().points, [VertexId(3).into(); 2]);
}

#[test]
fn mistakes_in_handles_are_named() {
    for (text, expected) in [
        ("", "markers.csv: the file is empty, expected a header and rows"),
        ("\n \n", "markers.csv: the file is empty, expected a header and rows"),
        (
            "label,index\na,1\n",
            "markers.csv, line 1: the header has no column \"vertex\", found \"label,index\", \
             expected label,vertex (separated by commas)",
        ),
        (
            "\nlabel;vertex\na;1\n",
            "markers.csv, line 2: the columns are separated by semicolons, expected commas between columns and points in \
             numbers; export the table in this form",
        ),
        (
            "label,vertex,note\na,1,x\n",
            "markers.csv, line 1: column 3 of the header is \"note\", expected label,vertex and no other column",
        ),
        (
            "label,vertex,label\na,1,x\n",
            "markers.csv, line 1: column 3 of the header is \"label\", expected label,vertex and no other column",
        ),
        (
            "label,vertex\n",
            "markers.csv: has no handles, expected a row label,vertex under the header for each",
        ),
        (
            "label,vertex\na,1\n\nb,2\r\na,3\n",
            "markers.csv, line 5: the label \"a\" was given in line 2 already; every handle needs a label of its own",
        ),
        (
            "label,vertex\na,1\n ,2\n",
            "markers.csv, line 3: the label is empty, expected the name of a marker",
        ),
        (
            "label,vertex\na,1\nb\n",
            "markers.csv, line 3: the row's number of cells is 1, expected 2 as in the header; the file may be cut short",
        ),
        (
            "label,vertex\na,1,2\n",
            "markers.csv, line 2: the row's number of cells is 3, expected 2 as in the header; the file may be cut short",
        ),
    ] {
        assert_eq!(sentence(handles(text)), expected, "{text:?}");
    }
    for vertex in ["-1", "3.0", "1e3", "nose", "", "4294967296", "NaN"] {
        assert_eq!(
            sentence(handles(&format!("label,vertex\na,{vertex}\n"))),
            format!(
                "markers.csv, line 2: the vertex of handle \"a\" is {vertex:?}, \
                 expected a whole number from 0 to 4294967295"
            )
        );
    }
    let latin1 = sentence(decode_handles(b"label,vertex\na,1\nb\xfc,2\n", "markers.csv"));
    assert!(
        latin1.starts_with("markers.csv, line 3: cell 1 is \"b\u{fffd}\", expected UTF-8 text"),
        "{latin1}"
    );
}

#[test]
fn lines_count_quoted_line_ends() {
    let found = sentence(handles("label,vertex\n\"two\nlines\",1\na,x\n"));
    assert!(found.starts_with("markers.csv, line 4: "), "{found}");
}

#[test]
fn what_is_shown_of_a_file_stays_short() {
    let found = sentence(handles(&format!("label,vertex\na,{}\n", "9".repeat(100_000))));
    assert!(found.len() < 250 && found.contains("999\"…"), "{found}");
}

#[test]
fn written_handles_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("handles.csv");
    let mut all = abc();
    all.labels[1] = "with, comma and \"quotes\"".into();
    write_handles(&path, &all, None).unwrap();
    assert_eq!(read_handles(&path).unwrap(), all);
}

#[test]
fn handles_that_would_not_read_back_are_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("handles.csv");
    for (labels, vertices) in [
        (vec!["a", "a"], vec![1, 2]),
        (vec![" a"], vec![1]),
        (vec![""], vec![1]),
        (vec![], vec![]),
        (vec!["a", "b"], vec![1]),
    ] {
        let bad = Handles {
            labels: labels.into_iter().map(str::to_owned).collect(),
            points: vertices.into_iter().map(|v| VertexId(v).into()).collect(),
        };
        let found = sentence(write_handles(&path, &bad, None));
        assert!(found.contains("could not be read back"), "{found}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}

#[test]
fn a_file_that_is_not_there_is_an_io_error() {
    let path = Path::new("no/such/file.csv");
    assert!(matches!(read_handles(path), Err(Error::Io { path: p, .. }) if p == path));
    assert!(matches!(read_strain_edges(path, &[]), Err(Error::Io { path: p, .. }) if p == path));
}

#[test]
fn strain_edges_become_indices_in_the_order_of_the_file() {
    for text in ["a,b\nchin,nose\nbrow_right,brow_left\n", "b,a\r\nnose,chin\r\nbrow_left,brow_right\r\n"] {
        assert_eq!(edges(text).unwrap(), [[2, 3], [1, 0]], "{text:?}");
    }
}

#[test]
fn mistakes_in_strain_edges_are_named() {
    for (text, expected) in [
        (
            "a,c\nchin,nose\n",
            "edges.csv, line 1: the header has no column \"b\", found \"a,c\", expected a,b (separated by commas)",
        ),
        (
            "a,b\nchin,nose\nchin,Brow_Lft\n",
            "edges.csv, line 3: no handle is called \"Brow_Lft\" (did you mean \"brow_left\"?), \
             expected the label of one",
        ),
        ("a,b\nelbow,chin\n", "edges.csv, line 2: no handle is called \"elbow\", expected the label of one"),
        (
            "a,b\nchin,chin\n",
            "edges.csv, line 2: the edge joins \"chin\" to itself, expected two different handles",
        ),
        (
            "a,b\nchin,nose\nchin,brow_left\nnose,chin\n",
            "edges.csv, line 4: the edge from \"nose\" to \"chin\" was given in line 2 already; \
             give each pair once, in either order",
        ),
        (
            "a,b\n",
            "edges.csv: has no edges, expected a row a,b under the header for each; \
             edges = \"auto\" in the project file finds them",
        ),
    ] {
        assert_eq!(sentence(edges(text)), expected, "{text:?}");
    }
}

/// Bytes in which the readers' own syntax is frequent.
fn csv_like() -> impl Strategy<Value = Vec<u8>> {
    let piece = prop_oneof![
        Just(&b"label,vertex\n"[..]),
        Just(&b"a,b\n"[..]),
        Just(&b"\xef\xbb\xbf"[..]),
        Just(&b"\r\n"[..]),
        Just(&b","[..]),
        Just(&b"\""[..]),
        Just(&b"chin"[..]),
        Just(&b"nose"[..]),
        Just(&b"17"[..]),
        Just(&b"\xff"[..]),
        Just(&b" "[..]),
    ];
    prop_oneof![
        proptest::collection::vec(any::<u8>(), 0..200),
        proptest::collection::vec(piece, 0..40).prop_map(|pieces| pieces.concat()),
    ]
}

proptest! {
    #[test]
    fn any_bytes_give_handles_that_keep_their_promise_or_a_named_error(bytes in csv_like()) {
        match decode_handles(&bytes, "f.csv") {
            Ok(handles) => {
                prop_assert!(!handles.labels.is_empty());
                prop_assert_eq!(handles.labels.len(), handles.len());
                prop_assert_eq!(handles.labels.iter().collect::<HashSet<_>>().len(), handles.labels.len());
            }
            Err(error) => prop_assert!(error.to_string().starts_with("f.csv"), "{}", error),
        }
    }

    #[test]
    fn any_bytes_give_strain_edges_that_keep_their_promise_or_a_named_error(bytes in csv_like()) {
        match decode_strain_edges(&bytes, "f.csv", &labels()) {
            Ok(edges) => {
                prop_assert!(edges.iter().all(|&[a, b]| a != b && a < HandleId(4) && b < HandleId(4)));
                let pairs: HashSet<_> = edges.iter().map(|&[a, b]| (a.min(b), a.max(b))).collect();
                prop_assert_eq!(pairs.len(), edges.len());
            }
            Err(error) => prop_assert!(error.to_string().starts_with("f.csv"), "{}", error),
        }
    }

    #[test]
    fn handles_survive_writing_and_reading(
        given in proptest::collection::btree_map("[a-zäß_,\"'\\n;]([ a-z_,\"]{0,8}[a-z\"])?", point(), 1..20)
    ) {
        let (labels, points): (Vec<String>, Vec<SurfacePoint>) =
            given.into_iter().filter(|(label, _)| label.trim() == label).unzip();
        prop_assume!(!labels.is_empty());
        let handles = Handles { labels, points };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("h.csv");
        write_handles(&path, &handles, None).unwrap();
        prop_assert_eq!(read_handles(&path).unwrap(), handles);
    }
}
