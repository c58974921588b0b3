//! Transfers between faces whose answers are known, and between real heads.
mod mistakes;
mod prior;
mod proportions;
mod real_heads;
mod remesh;
mod remeshed;
mod same_topology;
mod support;
