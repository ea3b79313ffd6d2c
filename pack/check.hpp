// Judges a table by the reference results of a problem: the rules of check.py, in C++17 with the standard library alone.
//
//     #include "check.hpp"
//     for (const auto& each : pack::judged("path/of/pack", "sag", "mine.csv")) ...   // throws pack::BadInput
//
// check.cpp makes a program of it.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <locale>
#include <map>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace pack {

using Column = std::vector<double>;
using Table = std::map<std::string, Column>;

struct BadInput : std::runtime_error {
    using std::runtime_error::runtime_error;
};

struct Verdict {
    std::string signal, status, told;  // status: within, outside, beyond the horizon, or missing
};

inline std::string text(double value, int digits = 6) {
    std::ostringstream out;
    out.imbue(std::locale::classic());
    out.precision(digits);
    out << value;
    return out.str();
}

inline std::string trimmed(const std::string& field) {
    const char* blanks = " \t\r\"";
    const auto first = field.find_first_not_of(blanks);
    return first == std::string::npos ? "" : field.substr(first, field.find_last_not_of(blanks) - first + 1);
}

// The number of a field, NaN for an empty one; `place` says where it stands. The program's locale does not matter.
inline double number(const std::string& field, const std::string& place) {
    static const std::regex no_number("|[+-]?nan", std::regex::icase), infinite("[+-]?inf(inity)?", std::regex::icase);
    if (std::regex_match(field, no_number)) return NAN;
    if (std::regex_match(field, infinite)) return field[0] == '-' ? -INFINITY : INFINITY;
    double value = 0;
    std::istringstream in(field);
    in.imbue(std::locale::classic());
    if (!(in >> value) || in.peek() != EOF) throw BadInput(place + ": not a number: " + field);
    return value;
}

inline Table read_table(const std::string& file) {
    std::ifstream in(file);
    if (!in) throw BadInput(file + ": cannot be read");
    std::vector<std::string> names;
    Table table;
    long count = 0;
    for (std::string line; std::getline(in, line);) {
        if (count == 0 && line.compare(0, 3, "\xEF\xBB\xBF") == 0) line.erase(0, 3);
        if (trimmed(line).empty()) continue;
        std::vector<std::string> fields;
        std::istringstream rest(line + ",");  // so that an empty last field counts
        for (std::string field; std::getline(rest, field, ',');) fields.push_back(trimmed(field));
        const std::string row = file + ", row " + std::to_string(++count);
        if (count == 1) {
            bool once = true;
            for (const auto& name : names = fields) once &= table.emplace(name, Column()).second || name.empty();
            if (once && table.count("time")) continue;
            throw BadInput(file + ": the first line must have `time` and each name once, separated by commas, without units");
        }
        if (fields.size() != names.size()) throw BadInput(row + ": " + std::to_string(fields.size()) + " fields, " + std::to_string(names.size()) + " names");
        for (size_t k = 0; k < fields.size(); ++k) table[names[k]].push_back(number(fields[k], row));
    }
    const Column& time = table["time"];
    const bool falls = std::adjacent_find(time.begin(), time.end(), [](double a, double b) { return !(a < b); }) != time.end();
    if (time.size() < 2 || falls) throw BadInput(file + ": the times do not increase, or are fewer than two");
    return table;
}

// The value at t of the polynomial through the nearest six rows, by Lagrange's formula.
inline double interpolated(const Column& times, const Column& values, double t) {
    const long after = std::upper_bound(times.begin(), times.end(), t) - times.begin(), last = static_cast<long>(times.size()) - 6;
    const long first = std::min(std::max(after - 3, 0L), last);
    double value = 0;
    for (long i = first; i < first + 6; ++i) {
        double weight = 1;
        for (long j = first; j < first + 6; ++j)
            if (j != i) weight *= (t - times[j]) / (times[i] - times[j]);
        value += weight * values[i];
    }
    return value;
}

inline Verdict judged_signal(const std::string& name, double bound, double horizon, const Table& right, const Table& table) {
    if (!table.count(name)) return {name, "missing", ""};
    const Column &times = right.at("time"), &values = right.at(name), &time = table.at("time"), &own = table.at(name);
    const double begin = times.front(), slack = 1e-9 * (times.back() - begin), longest = (horizon - begin) / 50 + slack;
    double before = begin, worst = -1, at = begin;
    std::string gap, later;  // what is said of the first row of each kind
    const auto look_for_gap = [&](double t) {
        if (gap.empty() && t - before > longest) gap = "no row between " + text(before) + " and " + text(t) + " s; the horizon is " + text(horizon) + " s";
        before = t;
    };
    for (size_t k = 0; k < time.size(); ++k) {
        const double t = time[k], error = std::isfinite(own[k]) ? std::abs(own[k] - interpolated(times, values, t)) : INFINITY;
        if (t > horizon + slack) {
            if (later.empty() && t <= times.back() + slack && error > bound) later = "within up to " + text(horizon) + " s; off from " + text(t) + " s";
        } else if (t >= begin - slack) {
            look_for_gap(t);
            if (error > worst) worst = error, at = t;
        }
    }
    if (worst < 0) return {name, "beyond the horizon", "no row from " + text(begin) + " to " + text(horizon) + " s"};
    look_for_gap(horizon);
    const std::string off = "off by " + text(worst, 2), limit = ", bound " + text(bound, 2);
    if (!gap.empty()) return {name, "outside", gap};
    if (worst > bound) return {name, "outside", off + " at " + text(at) + " s" + limit};
    if (!later.empty()) return {name, "beyond the horizon", later};
    return {name, "within", off + limit};
}

// The verdicts on the signals of a table; `share` of each signal's largest value is added to its bound.
inline std::vector<Verdict> judged(const std::string& folder, const std::string& problem, const std::string& file, double share = 0) {
    if (!(0 <= share && share <= 0.5)) throw BadInput(text(share) + ": the share is a number from 0 to 0.5, such as 0.01 for one per cent");
    std::ifstream in(folder + "/" + problem + "/bounds.json");
    if (!in) throw BadInput(problem + ": no such problem");
    const std::string bounds((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    const Table right = read_table(folder + "/" + problem + "/results.csv"), table = read_table(file);
    const std::regex entry("\"(\\w+)\": \\{\"bound\": ([^,]+), \"horizon\": ([^,]+), \"scale\": ([^,]+),");  // a line for each signal
    std::vector<Verdict> verdicts;
    for (std::sregex_iterator each(bounds.begin(), bounds.end(), entry), end; each != end; ++each) {
        const auto value = [&](int place) { return number((*each)[place], problem + "/bounds.json"); };
        verdicts.push_back(judged_signal((*each)[1], value(2) + share * value(4), value(3), right, table));
    }
    if (std::all_of(verdicts.begin(), verdicts.end(), [](const Verdict& each) { return each.status == "missing"; })) throw BadInput(file + ": has none of the signals of " + problem);
    return verdicts;
}

}  // namespace pack
