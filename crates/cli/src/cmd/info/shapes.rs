//! `rhytid info` of a mesh with shapes: blend shapes of USD, morph targets of glTF.

use super::shape::{Shape, list, row};
use rhytid::core::human;
use rhytid::formats::mesh::{self, ALIKE, Shapes, shape_groups};
use serde::Serialize;
use std::path::Path;

#[derive(Serialize)]
pub(super) struct ShapesInfo {
    pub name: String,
    #[serde(flatten)]
    shape: Shape,
    /// Their names.
    shapes: Vec<String>,
    details: Vec<Details>,
    groups: Vec<Group>,
}

/// What a shape does.
#[derive(Serialize)]
struct Details {
    name: String,
    /// The number of vertices that it moves.
    vertices: usize,
    /// The length of the largest displacement, in mesh units.
    largest: f64,
    /// The shape before it that is most like it; null where none has anything in common with it.
    most_like: Option<String>,
    /// The cosine of the angle between their displacements.
    likeness: f64,
}

/// Shapes of the left and the right side.
#[derive(Serialize)]
struct Group {
    name: String,
    shapes: Vec<String>,
}

impl ShapesInfo {
    pub(super) fn new(path: &Path, read: &Shapes) -> Self {
        let Shapes { neutral, shapes, .. } = read;
        let named = |number: &usize| shapes[*number].name.clone();
        let pairs = shape_groups(shapes).into_iter().filter(|group| group.shapes.len() > 1);
        Self {
            name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            shape: Shape::from_mesh(neutral),
            shapes: shapes.iter().map(|shape| shape.name.clone()).collect(),
            details: (0..shapes.len()).map(|number| details(number, shapes)).collect(),
            groups: pairs
                .map(|group| Group { name: group.name, shapes: group.shapes.iter().map(named).collect() })
                .collect(),
        }
    }

    pub(super) fn rows(&self, unit: &str) -> Vec<[String; 2]> {
        let mut rows = self.shape.rows(unit);
        rows.push(row("shapes", list(&self.shapes)));
        let groups: Vec<String> = self.groups.iter().map(|group| group.name.clone()).collect();
        if !groups.is_empty() {
            rows.push(row("left and right", list(&groups)));
        }
        let still: Vec<String> =
            self.details.iter().filter(|shape| shape.vertices == 0).map(|shape| shape.name.clone()).collect();
        if !still.is_empty() {
            rows.push(row("move nothing", list(&still)));
        }
        for shape in self.details.iter().filter(|shape| shape.likeness > ALIKE) {
            let other = shape.most_like.as_deref().unwrap_or_default();
            let likeness = human::number(shape.likeness * 100.0);
            rows.push(row("alike", format!("{} and {other}, to {likeness} %", shape.name)));
        }
        rows
    }
}

fn details(number: usize, shapes: &[mesh::Shape]) -> Details {
    let shape = &shapes[number];
    let lengths = shape.moved.iter().map(|(_, by)| by.iter().map(|x| x * x).sum::<f64>().sqrt());
    let mut details = Details {
        name: shape.name.clone(),
        vertices: shape.moved.len(),
        largest: lengths.fold(0.0, f64::max),
        most_like: None,
        likeness: 0.0,
    };
    // Each two are named once: at the later one.
    for other in &shapes[..number] {
        let likeness = mesh::likeness(other, shape);
        if likeness > details.likeness {
            details.likeness = likeness;
            details.most_like = Some(other.name.clone());
        }
    }
    details
}
