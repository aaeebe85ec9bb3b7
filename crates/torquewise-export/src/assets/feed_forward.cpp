// Joint states and a desired motion → effort: the torque the model expects for the desired motion,
// and a correction of what is left. MODEL(name) and N are defined above, REMEMBERS where friction
// remembers the path; it then follows that of the desired motion, from the start of the node on.

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "rclcpp/rclcpp.hpp"
#include "sensor_msgs/msg/joint_state.hpp"
#include "std_msgs/msg/float64_multi_array.hpp"
#include "trajectory_msgs/msg/joint_trajectory_point.hpp"

using Joints = std::array<double, N>;

class FeedForward : public rclcpp::Node
{
public:
  FeedForward() : Node("feed_forward")
  {
    std::vector<std::string> names;
    for (int joint = 0; joint < N; ++joint) names.emplace_back(MODEL(joint_name)(joint));
    joints_ = declare_parameter("joints", names);
    if (joints_.size() != N) throw std::invalid_argument("joints: one name per joint is needed");
    kp_ = gains("kp");
    kd_ = gains("kd");
    max_effort_ = gains("max_effort");
    gravity_only_ = declare_parameter("gravity_only", false);
    for (double limit : max_effort_) {
      if (!(limit > 0.0)) {
        throw std::invalid_argument("max_effort: give each joint a limit above 0 [N m]");
      }
    }
    effort_ = create_publisher<std_msgs::msg::Float64MultiArray>("effort_controller/commands", 1);
    reference_ = create_subscription<trajectory_msgs::msg::JointTrajectoryPoint>(
      "~/reference", 1,
      [this](trajectory_msgs::msg::JointTrajectoryPoint::SharedPtr point) { desire(*point); });
    state_ = create_subscription<sensor_msgs::msg::JointState>(
      "joint_states", rclcpp::SensorDataQoS(),
      [this](sensor_msgs::msg::JointState::SharedPtr state) { command(*state); });
#ifdef REMEMBERS
    MODEL(reset)(&memory_);
#endif
    RCLCPP_INFO(get_logger(), "%s", MODEL(version)());
  }

private:
  // A number for each joint, zeros if not given.
  Joints gains(const std::string & name)
  {
    const auto values = declare_parameter(name, std::vector<double>(N, 0.0));
    if (values.size() != N) throw std::invalid_argument(name + ": one number per joint is needed");
    Joints gains;
    std::copy(values.begin(), values.end(), gains.begin());
    return gains;
  }

  // Takes a desired motion; velocities and accelerations that are not given are zero.
  void desire(const trajectory_msgs::msg::JointTrajectoryPoint & point)
  {
    Joints q, dq, ddq;
    if (!take(point.positions, false, q) || !take(point.velocities, true, dq) ||
      !take(point.accelerations, true, ddq))
    {
      RCLCPP_ERROR(get_logger(), "a reference needs %d finite numbers of each kind", N);
      return;
    }
    q_ = q, dq_ = dq, ddq_ = ddq;
#ifdef REMEMBERS
    MODEL(step)(&memory_, q_.data());
#endif
    desired_ = true;
  }

  static bool take(const std::vector<double> & from, bool may_be_missing, Joints & to)
  {
    if (from.empty() && may_be_missing) {
      to.fill(0.0);
      return true;
    }
    if (from.size() != N) return false;
    std::copy(from.begin(), from.end(), to.begin());
    return std::all_of(to.begin(), to.end(), [](double x) { return std::isfinite(x); });
  }

  // Commands at the rate of the joint states, once there is something to reach.
  void command(const sensor_msgs::msg::JointState & state)
  {
    if (!desired_) return;
    Joints tau;
    if (gravity_only_) {
      MODEL(step1)(q_.data(), tau.data());
    } else {
#ifdef REMEMBERS
      MODEL(torque_after)(&memory_, dq_.data(), ddq_.data(), tau.data());
#else
      MODEL(torque)(q_.data(), dq_.data(), ddq_.data(), tau.data());
#endif
    }
    for (std::size_t joint = 0; joint < N; ++joint) {
      const auto name = std::find(state.name.begin(), state.name.end(), joints_[joint]);
      const auto place = static_cast<std::size_t>(name - state.name.begin());
      if (place >= state.position.size() || place >= state.velocity.size()) {
        RCLCPP_ERROR_THROTTLE(
          get_logger(), *get_clock(), 1000, "no position and velocity of joint %s",
          joints_[joint].c_str());
        return;
      }
      tau[joint] += kp_[joint] * (q_[joint] - state.position[place]) +
        kd_[joint] * (dq_[joint] - state.velocity[place]);
      if (!std::isfinite(tau[joint])) return;
      tau[joint] = std::clamp(tau[joint], -max_effort_[joint], max_effort_[joint]);
    }
    std_msgs::msg::Float64MultiArray effort;
    effort.data.assign(tau.begin(), tau.end());
    effort_->publish(effort);
  }

  std::vector<std::string> joints_;
  Joints kp_, kd_, max_effort_, q_, dq_, ddq_;
#ifdef REMEMBERS
  MODEL(state) memory_;
#endif
  bool gravity_only_ = false;
  bool desired_ = false;
  rclcpp::Publisher<std_msgs::msg::Float64MultiArray>::SharedPtr effort_;
  rclcpp::Subscription<trajectory_msgs::msg::JointTrajectoryPoint>::SharedPtr reference_;
  rclcpp::Subscription<sensor_msgs::msg::JointState>::SharedPtr state_;
};

int main(int argc, char ** argv)
{
  rclcpp::init(argc, argv);
  rclcpp::spin(std::make_shared<FeedForward>());
  rclcpp::shutdown();
  return 0;
}
