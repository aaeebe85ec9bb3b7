//! Every route and selector beside planted truths and brute force.

mod contract;
mod criterion;
mod elimination;
mod kmeans;
mod lasso;
mod planted;
mod problem;
mod random_design;
mod routes;
