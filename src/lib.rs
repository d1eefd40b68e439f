pub mod cpu;
pub mod pack;
pub mod scene;
pub mod shared;
