mod host_application;
mod memory;
mod results;
mod support;
mod synchronization;
