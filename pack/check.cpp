// check PROBLEM FILE [SHARE]: see check.hpp. Build it in this folder with: g++ -std=c++17 -O1 -o check check.cpp
#include <cstdio>

#include "check.hpp"

int main(int count, char** arguments) {
    const std::string here = __FILE__, folder = here.find('/') == std::string::npos ? "." : here.substr(0, here.rfind('/'));
    if (count < 3 || count > 4) return std::fprintf(stderr, "check PROBLEM FILE [SHARE]\n"), 2;
    try {
        int code = 0;
        for (const auto& each : pack::judged(folder, arguments[1], arguments[2], count == 4 ? std::stod(arguments[3]) : 0)) {
            std::printf("%-18s %-18s %s\n", each.signal.c_str(), each.status.c_str(), each.told.c_str());
            if (each.status == "outside") code = 1;
        }
        return code;
    } catch (const std::exception& error) {
        return std::fprintf(stderr, "%s\n", error.what()), 2;
    }
}
