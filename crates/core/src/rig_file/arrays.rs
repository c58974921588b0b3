//! The arrays of a rig file.

use super::{LearnedMetadata, LookMetadata, Metadata, TextureMetadata};
use crate::openings::{ACROSS, LEADERS};
use crate::{
    Contact, Error, Examples, Eyeball, Faces, FineScale, HandleId, HandleSet, Influences, Learned, LidVertex,
    Materials, Openings, Result, RigParts, RimFollower, RimVertex, StrainEdgeId, Surface, SurfacePoint,
    Table, Texture, Uvs, VertexId,
};
use safetensors::tensor::{Dtype, SafeTensors, TensorView};

fn vectors<const N: usize>(numbers: Vec<f32>) -> Vec<[f32; N]> {
    numbers.as_chunks::<N>().0.to_vec()
}

fn pairs(numbers: Vec<u32>) -> Vec<[HandleId; 2]> {
    numbers.as_chunks::<2>().0.iter().map(|pair| pair.map(HandleId)).collect()
}

fn ids<I>(numbers: Vec<u32>, id: fn(u32) -> I) -> Vec<I> {
    numbers.into_iter().map(id).collect()
}

/// The arrays of a file, each checked for type and shape as it is taken out.
pub(super) struct Arrays<'a> {
    pub(super) tensors: SafeTensors<'a>,
    pub(super) name: &'a str,
}

impl Arrays<'_> {
    /// All parts of the rig, still unchecked beyond their types and shapes.
    pub(super) fn rig(&self, metadata: Metadata) -> Result<RigParts> {
        let rest = vectors::<3>(self.f32s("rest", &[None, Some(3)])?);
        let points = self.points()?;
        let strain_edges = pairs(self.u32s("strain_edges", &[None, Some(2)])?);
        let (v, h, f, p) = (rest.len(), points.len(), strain_edges.len(), metadata.examples.len());
        let n = p + 1;
        let uvs = self.uvs()?;
        let materials = self.materials(metadata.materials, metadata.looks, metadata.textures)?;
        if metadata.learned.is_none() && metadata.method != "chapter" {
            return Err(self.fail("its metadata cannot be read (missing field `learned`)"));
        }
        let learned = metadata.learned.map(|learned| self.learned(learned, v, p)).transpose()?;
        let surface = Surface {
            name: metadata.name,
            metres_per_unit: metadata.metres_per_unit,
            up_axis: metadata.up_axis,
            faces: Faces {
                counts: self.u32s("face_counts", &[None])?,
                indices: self.u32s("face_indices", &[None])?,
            },
            uvs,
            materials,
            triangles: self.u32s("triangles", &[None, Some(3)])?.as_chunks().0.to_vec(),
            tangent_neighbors: ids(self.u32s("frame_neighbors", &[Some(v)])?, VertexId),
            joined: match self.has("joined_vertices") {
                true => Some(ids(self.u32s("joined_vertices", &[Some(v)])?, VertexId)),
                false => None,
            },
            rest,
        };
        // A vertex that does not exist is reported when the rig is made.
        let exists = |point: &SurfacePoint| point.triangle().iter().all(|v| v.index() < surface.rest.len());
        let at = |point: &SurfacePoint| match exists(point) {
            true => point.at(&surface.rest),
            false => [0.0; 3],
        };
        Ok(RigParts {
            handles: HandleSet {
                labels: metadata.labels,
                rest: points.iter().map(at).collect(),
                points,
                strain_edges,
                rotations: metadata.rotations,
            },
            surface,
            bending_length: metadata.bending_length,
            basis: self.table("basis", v, Some(h))?,
            influences: Influences {
                edges: self.ids("influence_edges", v, StrainEdgeId)?,
                weights: self.table("influence_weights", v, None)?,
                beta: metadata.beta.unwrap_or(f64::INFINITY),
            },
            fine_scale: FineScale {
                pose_features: self.table("pose_features", n, Some(f))?,
                rbf_weights: self.vectors("rbf_weights", v, n)?,
            },
            examples: Examples { names: metadata.examples, handles: self.vectors("example_handles", p, h)? },
            learned,
        })
    }

    /// The points of the handles, from one vertex each or from three with their weights.
    fn points(&self) -> Result<Vec<SurfacePoint>> {
        if !self.has("handle_weights") {
            return Ok(ids(self.u32s("handles", &[None])?, |v| VertexId(v).into()));
        }
        let weights = vectors::<3>(self.f32s("handle_weights", &[None, Some(3)])?);
        let corners = self.u32s("handles", &[Some(weights.len()), Some(3)])?;
        let of_handle = |(h, (corners, weights)): (usize, (&[u32; 3], &[f32; 3]))| {
            let [first, second, third] = weights.map(f64::from);
            let point = SurfacePoint::new(corners.map(VertexId), [first, second, third]);
            point.filter(|_| (first + second + third - 1.0).abs() < 1e-5).ok_or_else(|| {
                let found = format!("{first}, {second} and {third}");
                self.fail(format!(
                    "handle_weights[{h}] is {found}, expected weights from 0 on whose sum is 1"
                ))
            })
        };
        corners.as_chunks::<3>().0.iter().zip(&weights).enumerate().map(of_handle).collect()
    }

    fn uvs(&self) -> Result<Option<Uvs>> {
        if !self.has("uvs") {
            return match self.has("uv_indices") {
                true => Err(self.fail("has an array `uv_indices`, but no `uvs`")),
                false => Ok(None),
            };
        }
        Ok(Some(Uvs {
            values: vectors::<2>(self.f32s("uvs", &[None, Some(2)])?),
            corners: match self.has("uv_indices") {
                true => Some(self.u32s("uv_indices", &[None])?),
                false => None,
            },
        }))
    }

    fn materials(
        &self,
        names: Vec<String>,
        looks: Vec<LookMetadata>,
        textures: Vec<TextureMetadata>,
    ) -> Result<Option<Materials>> {
        if !self.has("face_materials") && names.is_empty() {
            return Ok(None);
        }
        let mut materials = Materials::named(names, self.u32s("face_materials", &[None])?);
        if !looks.is_empty() && looks.len() != materials.list.len() {
            return Err(self.fail(format!(
                "its metadata has {} looks for {} materials, expected one for each",
                looks.len(),
                materials.list.len()
            )));
        }
        for (material, LookMetadata { tissue, stated }) in materials.list.iter_mut().zip(looks) {
            (material.tissue, material.stated) = (tissue, stated);
        }
        materials.textures = self.textures(textures)?;
        Ok(Some(materials))
    }

    fn textures(&self, textures: Vec<TextureMetadata>) -> Result<Vec<Texture>> {
        if textures.is_empty() {
            return Ok(Vec::new());
        }
        let view = self.view("texture_bytes", Dtype::U8, &[None])?;
        let mut rest = view.data();
        let mut found = Vec::new();
        for TextureMetadata { name, path, bytes } in textures {
            let split = usize::try_from(bytes).ok().and_then(|bytes| rest.split_at_checked(bytes));
            let Some((bytes, behind)) = split else {
                return Err(self.fail(format!(
                    "array `texture_bytes` ends within the texture {name}, expected {bytes} bytes of it"
                )));
            };
            rest = behind;
            found.push(Texture { name, path, bytes: bytes.into() });
        }
        if !rest.is_empty() {
            return Err(
                self.fail(format!("array `texture_bytes` has {} bytes more than its textures", rest.len()))
            );
        }
        Ok(found)
    }

    /// What is learned from `examples` for V vertices.
    fn learned(&self, metadata: LearnedMetadata, vertices: usize, examples: usize) -> Result<Learned> {
        let LearnedMetadata { share, ridge, wrinkle_ridge, marker_noise, reach, wrinkle_strains } = metadata;
        Ok(Learned {
            share,
            ridge,
            wrinkle_ridge,
            marker_noise,
            reach: reach.unwrap_or(f64::INFINITY),
            prior_lengths: match self.has("prior_lengths") {
                true => self.f32s("prior_lengths", &[None])?,
                false => Vec::new(),
            },
            wrinkle_strains,
            anchors: self.ids("anchors", vertices, HandleId)?,
            anchor_weights: self.table("anchor_weights", vertices, None)?,
            feature_gains: self.table("feature_gains", vertices, None)?,
            example_weights: match share > 0.0 && examples > 0 {
                true => self.vectors("example_weights", vertices, examples)?,
                false => Table::without_columns(vertices),
            },
            variances: self.f32s("variances", &[Some(vertices)])?,
            contact: Contact { openings: self.openings()?, ..self.eyeballs()? },
        })
    }

    /// The contact without openings.
    fn eyeballs(&self) -> Result<Contact> {
        if !self.has("eyeball_corners") {
            return Ok(Contact::default());
        }
        let corners = self.u32s("eyeball_corners", &[None, Some(4)])?;
        let corners = corners.as_chunks::<4>().0;
        let weights = vectors::<4>(self.f32s("eyeball_weights", &[Some(corners.len()), Some(4)])?);
        let eyeballs = corners.iter().zip(weights);
        let vertices = self.u32s("lid_vertices", &[None, Some(3)])?;
        let vertices = vertices.as_chunks::<3>().0;
        let distances = vectors::<2>(self.f32s("lid_distances", &[Some(vertices.len()), Some(2)])?);
        let lids = vertices.iter().zip(distances);
        Ok(Contact {
            eyeballs: eyeballs
                .map(|(corners, weights)| Eyeball { corners: corners.map(VertexId), weights })
                .collect(),
            lids: lids
                .map(|(&[vertex, eyeball, leader], [nearest, farthest])| LidVertex {
                    vertex: VertexId(vertex),
                    eyeball,
                    leader,
                    nearest,
                    farthest,
                })
                .collect(),
            openings: Openings::default(),
        })
    }

    fn openings(&self) -> Result<Openings> {
        if !self.has("rim_vertices") {
            return Ok(Openings::default());
        }
        let vertices = self.u32s("rim_vertices", &[None])?;
        let across = self.u32s("rim_across", &[Some(vertices.len()), Some(ACROSS)])?;
        let gaps = vectors::<2>(self.f32s("rim_gaps", &[Some(vertices.len()), Some(2)])?);
        let rims = vertices.into_iter().zip(across.as_chunks::<ACROSS>().0).zip(gaps);
        let moved = self.u32s("rim_followers", &[None])?;
        let leaders = self.u32s("rim_leaders", &[Some(moved.len()), Some(LEADERS)])?;
        let weights = self.f32s("rim_leader_weights", &[Some(moved.len()), Some(LEADERS)])?;
        let weights = vectors::<LEADERS>(weights);
        let followers = moved.into_iter().zip(leaders.as_chunks::<LEADERS>().0).zip(weights);
        Ok(Openings {
            rims: rims
                .map(|((vertex, &across), [reach, least_gap])| RimVertex {
                    vertex: VertexId(vertex),
                    across,
                    reach,
                    least_gap,
                })
                .collect(),
            followers: followers
                .map(|((vertex, &leaders), weights)| RimFollower {
                    vertex: VertexId(vertex),
                    leaders,
                    weights,
                })
                .collect(),
        })
    }

    /// The error of a damaged file.
    fn fail(&self, what: impl std::fmt::Display) -> Error {
        Error::rig_damaged(format!("{}: {what}; solve the rig again", self.name))
    }

    fn has(&self, array: &str) -> bool {
        self.tensors.tensor(array).is_ok()
    }

    /// `shape` has `None` where any extent is allowed.
    fn view(&self, array: &str, dtype: Dtype, shape: &[Option<usize>]) -> Result<TensorView<'_>> {
        let view = self.tensors.tensor(array).map_err(|_| self.fail(format!("has no array `{array}`")))?;
        let fits = view.shape().len() == shape.len()
            && view.shape().iter().zip(shape).all(|(found, expected)| expected.is_none_or(|e| e == *found));
        if view.dtype() != dtype || !fits {
            let extents: Vec<String> =
                shape.iter().map(|e| e.map_or("any".into(), |e| e.to_string())).collect();
            return Err(self.fail(format!(
                "array `{array}` is {:?} {:?}, expected {dtype:?} [{}]",
                view.dtype(),
                view.shape(),
                extents.join(", ")
            )));
        }
        Ok(view)
    }

    fn u32s(&self, array: &str, shape: &[Option<usize>]) -> Result<Vec<u32>> {
        Ok(u32s_of(&self.view(array, Dtype::U32, shape)?))
    }

    fn f32s(&self, array: &str, shape: &[Option<usize>]) -> Result<Vec<f32>> {
        Ok(f32s_of(&self.view(array, Dtype::F32, shape)?))
    }

    /// V×N ids, for any N.
    fn ids<I>(&self, array: &str, rows: usize, id: fn(u32) -> I) -> Result<Table<I>> {
        let view = self.view(array, Dtype::U32, &[Some(rows), None])?;
        Table::try_new(rows, view.shape()[1], ids(u32s_of(&view), id))
    }

    fn table(&self, array: &str, rows: usize, columns: Option<usize>) -> Result<Table<f32>> {
        let view = self.view(array, Dtype::F32, &[Some(rows), columns])?;
        Table::try_new(rows, view.shape()[1], f32s_of(&view))
    }

    fn vectors(&self, array: &str, rows: usize, columns: usize) -> Result<Table<[f32; 3]>> {
        let numbers = self.f32s(array, &[Some(rows), Some(columns), Some(3)])?;
        Table::try_new(rows, columns, vectors(numbers))
    }
}

fn u32s_of(view: &TensorView<'_>) -> Vec<u32> {
    view.data().as_chunks().0.iter().map(|b| u32::from_le_bytes(*b)).collect()
}

fn f32s_of(view: &TensorView<'_>) -> Vec<f32> {
    view.data().as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
}
