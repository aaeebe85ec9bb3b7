// Joint states with effort → external torque by the momentum observer, and whether it is above a
// threshold. MODEL(name) and N are defined above.

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "rclcpp/rclcpp.hpp"
#include "sensor_msgs/msg/joint_state.hpp"
#include "std_msgs/msg/bool.hpp"

using Joints = std::array<double, N>;

class ExternalTorque : public rclcpp::Node
{
public:
  ExternalTorque() : Node("external_torque")
  {
    std::vector<std::string> names;
    for (int joint = 0; joint < N; ++joint) names.emplace_back(MODEL(joint_name)(joint));
    joints_ = declare_parameter("joints", names);
    if (joints_.size() != N) throw std::invalid_argument("joints: one name per joint is needed");
    const double bandwidth = declare_parameter("bandwidth", 10.0);
    if (!(bandwidth > 0.0)) throw std::invalid_argument("bandwidth: above 0 Hz is needed");
    gain_ = 2.0 * 3.14159265358979323846 * bandwidth;
    longest_gap_ = declare_parameter("longest_gap", 0.1);
    thresholds_ = declare_parameter("thresholds", std::vector<double>(N, 0.0));
    if (thresholds_.size() != N) {
      throw std::invalid_argument("thresholds: one number per joint is needed");
    }
    MODEL(observer_reset)(&observer_);
    external_ = create_publisher<sensor_msgs::msg::JointState>("~/external_torque", 1);
    contact_ = create_publisher<std_msgs::msg::Bool>("~/contact", 1);
    state_ = create_subscription<sensor_msgs::msg::JointState>(
      "joint_states", rclcpp::SensorDataQoS(),
      [this](sensor_msgs::msg::JointState::SharedPtr state) { observe(*state); });
    RCLCPP_INFO(get_logger(), "%s", MODEL(version)());
  }

private:
  void observe(const sensor_msgs::msg::JointState & state)
  {
    Joints q, dq, tau, external;
    for (std::size_t joint = 0; joint < N; ++joint) {
      const auto name = std::find(state.name.begin(), state.name.end(), joints_[joint]);
      const auto place = static_cast<std::size_t>(name - state.name.begin());
      if (place >= state.position.size() || place >= state.velocity.size() ||
        place >= state.effort.size())
      {
        RCLCPP_ERROR_THROTTLE(
          get_logger(), *get_clock(), 1000, "no position, velocity and effort of joint %s",
          joints_[joint].c_str());
        return;
      }
      q[joint] = state.position[place];
      dq[joint] = state.velocity[place];
      tau[joint] = state.effort[place];
      if (!std::isfinite(q[joint] + dq[joint] + tau[joint])) {
        MODEL(observer_reset)(&observer_);
        return;
      }
    }
    const auto & stamp = state.header.stamp;
    const double time = static_cast<double>(stamp.sec) + 1e-9 * static_cast<double>(stamp.nanosec);
    const double dt = time - time_;
    time_ = time;
    if (dt < 0.0 || dt > longest_gap_) MODEL(observer_reset)(&observer_);
    MODEL(observer_step)(
      &observer_, gain_, dt, q.data(), dq.data(), tau.data(), external.data());
    sensor_msgs::msg::JointState answer;
    answer.header = state.header;
    answer.name = joints_;
    answer.effort.assign(external.begin(), external.end());
    external_->publish(answer);
    std_msgs::msg::Bool contact;
    for (std::size_t joint = 0; joint < N; ++joint) {
      const double threshold = thresholds_[joint];
      if (threshold > 0.0 && std::abs(external[joint]) > threshold) contact.data = true;
    }
    contact_->publish(contact);
  }

  std::vector<std::string> joints_;
  std::vector<double> thresholds_;
  double gain_ = 0.0, longest_gap_ = 0.0, time_ = 0.0;
  MODEL(observer) observer_;
  rclcpp::Publisher<sensor_msgs::msg::JointState>::SharedPtr external_;
  rclcpp::Publisher<std_msgs::msg::Bool>::SharedPtr contact_;
  rclcpp::Subscription<sensor_msgs::msg::JointState>::SharedPtr state_;
};

int main(int argc, char ** argv)
{
  rclcpp::init(argc, argv);
  rclcpp::spin(std::make_shared<ExternalTorque>());
  rclcpp::shutdown();
  return 0;
}
