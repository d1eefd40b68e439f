pub mod compare;
pub mod cpu;
pub mod error;
pub mod film;
pub mod output;
pub mod pack;
pub mod scene;
pub mod shared;
