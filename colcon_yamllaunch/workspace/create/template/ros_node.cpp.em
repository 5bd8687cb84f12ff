// The node `@(node)`: it greets again and again.

#include <chrono>
#include <memory>
#include <string>

#include <rclcpp/rclcpp.hpp>

/// Log a greeting every so often, and count how often.
class @(class_name) : public rclcpp::Node
{
public:
  @(class_name)()
  : Node("@(node)")
  {
    // Parameters are declared with their defaults. What the launch file or
    // `--ros-args -p period:=0.5` says goes before these.
    declare_parameter("greeting", "Hello");
    const double period = declare_parameter("period", 1.0);  // seconds
    timer_ = create_wall_timer(
      std::chrono::duration<double>(period), [this]() {greet();});
  }

private:
  /// Log the greeting once.
  void greet()
  {
    ++count_;
    const std::string greeting = get_parameter("greeting").as_string();
    RCLCPP_INFO(get_logger(), "%s %d", greeting.c_str(), count_);
  }

  int count_ = 0;
  rclcpp::TimerBase::SharedPtr timer_;
};

int main(int argc, char ** argv)
{
  rclcpp::init(argc, argv);
  rclcpp::spin(std::make_shared<@(class_name)>());
  rclcpp::shutdown();
  return 0;
}
