//! Every route and selector beside planted truths and brute force.

mod contract;
mod elimination;
mod kmeans;
mod lasso;
mod normal_equations;
mod planted;
mod random_design;
mod routes;
