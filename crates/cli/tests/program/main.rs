//! The program as a user runs it.

mod bad_input;
mod bad_rig;
mod bench;
mod budgets;
mod channels;
mod clients;
mod clips;
mod common;
mod contact;
mod curves;
mod device_choice;
mod drivers;
mod edits;
mod end_to_end;
mod example_space;
mod exports;
mod fade_and_head;
mod farm;
mod judging;
#[cfg(feature = "wgpu")]
mod levels;
#[cfg(target_os = "linux")]
mod limits;
mod live;
#[cfg(target_os = "linux")]
mod memory;
mod new_project;
mod oracles;
mod output;
mod outputs;
mod packing;
mod pages;
mod placing;
mod points;
mod prepare;
mod prior;
mod processors;
mod raw_torture;
mod reach;
#[cfg(feature = "wgpu")]
mod render;
mod retarget;
mod soft_markers;
mod space;
mod stitch;
mod summaries;
mod takes_folder;
mod tampered;
mod transfer;
mod usd;
mod welded;
#[cfg(all(target_os = "linux", feature = "view"))]
mod window;
mod words;
mod written_over;
