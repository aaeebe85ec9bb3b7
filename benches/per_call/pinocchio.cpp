// Nanoseconds of processor time per inverse dynamics by Pinocchio's RNEA: of a URDF, or of n revolute joints anywhere.

// What Pinocchio's own build files define.
#define BOOST_MPL_LIMIT_LIST_SIZE 30
#define BOOST_MPL_LIMIT_VECTOR_SIZE 30
#define BOOST_MPL_CFG_NO_PREPROCESSED_HEADERS
#define BOOST_FUSION_INVOKE_MAX_ARITY 12
#define PINOCCHIO_ENABLE_TEMPLATE_INSTANTIATION

#include <pinocchio/fwd.hpp>

#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/parsers/urdf.hpp>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <string>
#include <vector>

namespace pin = pinocchio;

static double now()
{
  timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return 1e9 * static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec);
}

static pin::Model revolute(int n)
{
  pin::Model model;
  pin::JointIndex parent = 0;
  for (int joint = 0; joint < n; ++joint) {
    const auto placement = pin::SE3::Random();
    const auto name = "joint" + std::to_string(joint);
    switch (joint % 3) {
      case 0: parent = model.addJoint(parent, pin::JointModelRZ(), placement, name); break;
      case 1: parent = model.addJoint(parent, pin::JointModelRY(), placement, name); break;
      default: parent = model.addJoint(parent, pin::JointModelRX(), placement, name); break;
    }
    model.appendBodyToJoint(parent, pin::Inertia::Random(), pin::SE3::Identity());
  }
  return model;
}

int main(int argc, char ** argv)
{
  if (argc != 2) return 2;
  const std::string arm = argv[1];
  pin::Model model;
  if (arm.find_first_not_of("0123456789") == std::string::npos) {
    model = revolute(std::atoi(arm.c_str()));
  } else {
    pin::urdf::buildModel(arm, model);
  }
  pin::Data data(model);
  const int states = 256, rounds = 201, calls = 2000;
  std::vector<Eigen::VectorXd> q, v, a;
  for (int k = 0; k < states; ++k) {
    q.push_back(3.0 * Eigen::VectorXd::Random(model.nq));
    v.push_back(Eigen::VectorXd::Random(model.nv));
    a.push_back(Eigen::VectorXd::Random(model.nv));
  }
  double sum = 0.0;
  std::vector<double> times;
  for (int round = 0; round < rounds; ++round) {
    const double start = now();
    for (int call = 0; call < calls; ++call) {
      const int k = call % states;
      sum += pin::rnea(model, data, q[k], v[k], a[k])[0];
    }
    times.push_back((now() - start) / calls);
  }
  std::sort(times.begin(), times.end());
  std::cout << model.nv << " " << times[rounds / 2] << " " << times.front() << "\n";
  return std::isfinite(sum) ? 0 : 1;
}
