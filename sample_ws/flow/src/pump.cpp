// Copyright 2026 The colcon-yamllaunch authors
// Licensed under the Apache License, Version 2.0

// Pump a litre every so often and say so, until stopped.

#include <cmath>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <optional>
#include <string>

// The longest pause in seconds: a day.
constexpr double kLongestPeriod = 86400.0;

// Seconds between two litres, or nothing if the text does not say that.
std::optional<double> parse_period(const std::string & text)
{
  char * end = nullptr;
  const double seconds = std::strtod(text.c_str(), &end);
  const bool is_number = !text.empty() && *end == '\0';
  if (!is_number || !(seconds > 0.0) || seconds > kLongestPeriod) {
    return std::nullopt;
  }
  return seconds;
}

// The signals that mean "please end": Ctrl-C, and a polite kill.
sigset_t stop_signals()
{
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  return signals;
}

int main(int argc, char ** argv)
{
  std::optional<double> period = 1.0;
  if (argc == 3 && std::string(argv[1]) == "--period") {
    period = parse_period(argv[2]);
  } else if (argc != 1) {
    period = std::nullopt;
  }
  if (!period) {
    std::cerr << "usage: pump [--period SECONDS], more than 0 and at most "
              << kLongestPeriod << std::endl;
    return 2;
  }

  timespec pause{};
  pause.tv_sec = static_cast<time_t>(std::floor(*period));
  pause.tv_nsec = static_cast<long>((*period - std::floor(*period)) * 1e9);

  // A blocked signal waits until sigtimedwait() takes it, so there is no
  // moment at which one could be missed, and no handler is needed.
  const sigset_t signals = stop_signals();
  sigprocmask(SIG_BLOCK, &signals, nullptr);

  unsigned long litres = 0;
  while (sigtimedwait(&signals, nullptr, &pause) < 0) {
    // std::endl flushes: the line shows at once, also through a pipe.
    std::cout << "Pumped " << ++litres << " l" << std::endl;
  }
  std::cout << "Pump stopped" << std::endl;
  return 0;
}
