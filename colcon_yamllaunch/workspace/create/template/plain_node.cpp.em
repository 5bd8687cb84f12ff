// Greet again and again, and count how often.

#include <chrono>
#include <cstring>
#include <fstream>
#include <iostream>
#include <string>
#include <thread>

/// What is set in the section of an INI file.
struct Settings
{
  std::string greeting = "Hello";
  double period = 1.0;  // seconds
};

/// Return the settings in a file, with defaults for what it does not say.
Settings read_settings(const char * path)
{
  Settings settings;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line); ) {
    const auto equals = line.find(" = ");
    if (equals == std::string::npos) {
      continue;
    }
    const std::string value = line.substr(equals + 3);
    if (line.substr(0, equals) == "greeting") {
      settings.greeting = value;
    } else if (line.substr(0, equals) == "period") {
      settings.period = std::stod(value);
    }
  }
  return settings;
}

/// Take `--settings FILE`, and `--times NUMBER` to end by itself.
int main(int argc, char ** argv)
{
  Settings settings;
  int times = -1;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--settings") == 0) {
      settings = read_settings(argv[i + 1]);
    } else if (std::strcmp(argv[i], "--times") == 0) {
      times = std::stoi(argv[i + 1]);
    }
  }
  for (int count = 1; times < 0 || count <= times; ++count) {
    // with its end, a line is written at once, also into a pipe
    std::cout << settings.greeting << ' ' << count << std::endl;
    std::this_thread::sleep_for(
      std::chrono::duration<double>(settings.period));
  }
  return 0;
}
