//! What comes in and goes out, through public functions alone. The programs that files are compared with come
//! from `cargo xtask setup`.

mod animation;
mod clips;
mod cut_while_read;
mod edits;
mod export;
mod gltf;
mod meshes;
mod pc2;
mod project;
mod project_errors;
mod project_examples;
mod project_maps;
mod raw_take;
mod sequences;
mod stitch;
mod tables;
mod takes;
mod takes_confidence;
mod takes_head;
mod takes_shared;
mod takes_warning;
mod usd_read;
