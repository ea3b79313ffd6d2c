// check PROBLEM FILE [SHARE]: see check.hpp. Build it with: g++ -std=c++17 -O1 -o check check.cpp
// It finds the problems beside the program, or beside this file.
#include <cstdio>
#include <filesystem>

#include "check.hpp"

int main(int count, char** arguments) {
    if (count < 3 || count > 4) return std::fprintf(stderr, "check PROBLEM FILE [SHARE]\n"), 2;
    try {
        int code = 0;
        const auto beside = [](const char* file) { return std::filesystem::path(file).parent_path() / "."; };
        const auto folder = std::filesystem::exists(beside(arguments[0]) / arguments[1] / "bounds.json") ? beside(arguments[0]) : beside(__FILE__);
        const double share = count == 4 ? pack::number(arguments[3], "share, such as 0.01 for one per cent") : 0;
        for (const auto& each : pack::judged(folder.string(), arguments[1], arguments[2], share)) {
            std::printf("%-18s %-18s %s\n", each.signal.c_str(), each.status.c_str(), each.told.c_str());
            if (each.status == "outside") code = 1;
        }
        return code;
    } catch (const std::exception& error) {
        return std::fprintf(stderr, "%s\n", error.what()), 2;
    }
}
