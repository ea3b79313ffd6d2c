# Judges a table by the reference results of a problem: the rules of check.py, in Julia without packages.
#
#     julia check.jl PROBLEM FILE [SHARE]
#
# or include("check.jl") and Pack.judged("sag", "mine.csv").
module Pack

struct BadInput <: Exception
    told::String
end

const NUMBER = r"^[+-]?(nan|inf(inity)?|(\d+\.?\d*|\.\d+)(e[+-]?\d+)?)$"i

"""The names of a CSV table and its rows, a matrix."""
function read_table(file)
    isfile(file) || throw(BadInput("$file: cannot be read"))
    lines = filter(line -> !isempty(strip(line)), split(replace(read(file, String), "\ufeff" => ""), r"\r?\n"))
    names = isempty(lines) ? String[] : [String(strip(strip(name), '"')) for name in split(lines[1], ",")]
    "time" in names && allunique(filter(!isempty, names)) ||
        throw(BadInput("$file: the first line must have `time` and each name once, separated by commas, without units"))
    rows = zeros(length(lines) - 1, length(names))
    for (k, line) in enumerate(lines[2:end])
        fields = strip.(split(line, ","))
        length(fields) == length(names) ||
            throw(BadInput("$file, row $(k + 1): $(length(fields)) fields, $(length(names)) names"))
        all(field -> isempty(field) || occursin(NUMBER, field), fields) || throw(BadInput("$file, row $(k + 1): not numbers: $line"))
        rows[k, :] = [isempty(field) ? NaN : parse(Float64, field) for field in fields]
    end
    time = rows[:, findfirst(==("time"), names)]
    length(time) > 1 && all(diff(time) .> 0) || throw(BadInput("$file: the times do not increase, or are fewer than two"))
    return names, rows
end

"""The value at t of the polynomial through the nearest six rows, by Lagrange's formula."""
function interpolated(times, values, t)
    first = min(max(searchsortedlast(times, t) - 2, 1), length(times) - 5)
    rows = first:first+5
    return sum(values[i] * prod((t - times[j]) / (times[i] - times[j]) for j in rows if j != i) for i in rows)
end

shown(value) = string(round(value; sigdigits=2))

"""Status (within, outside, or beyond the horizon) and a remark on a signal, of columns of times and values."""
function judged_signal(bound, horizon, times, values, own_times, own)
    begun, slack = times[1], 1e-9 * (times[end] - times[1])
    inside = findall(t -> begun - slack <= t <= times[end] + slack, own_times)
    errors = Dict(k => isfinite(own[k]) ? abs(own[k] - interpolated(times, values, own_times[k])) : Inf for k in inside)
    now = filter(k -> own_times[k] <= horizon + slack, inside)
    isempty(now) && return "beyond the horizon", "no row from $begun to $horizon s"
    marks = [begun; own_times[now]; horizon]
    gap = findfirst(>((horizon - begun) / 50 + slack), diff(marks))
    gap === nothing || return "outside", "no row between $(marks[gap]) and $(marks[gap+1]) s; the horizon is $horizon s"
    worst, at = findmax([errors[k] for k in now])
    worst > bound && return "outside", "off by $(shown(worst)) at $(own_times[now[at]]) s, bound $(shown(bound))"
    later = findfirst(k -> own_times[k] > horizon + slack && errors[k] > bound, inside)
    later === nothing || return "beyond the horizon", "within up to $horizon s; off from $(own_times[inside[later]]) s"
    return "within", "off by $(shown(worst)), bound $(shown(bound))"
end

"""A tuple (signal, status, remark) for each signal of a problem; throws BadInput."""
function judged(problem, file, share=0.0)
    0 <= share <= 0.5 || throw(BadInput("the share is a number from 0 to 0.5, such as 0.01 for one per cent"))
    folder = joinpath(@__DIR__, problem)
    isfile(joinpath(folder, "bounds.json")) || throw(BadInput("$problem: no such problem"))
    entry = r"\"(\w+)\": \{\"bound\": ([^,]+), \"horizon\": ([^,]+), \"scale\": ([^,]+),"  # a line for each signal
    names, right = read_table(joinpath(folder, "results.csv"))
    own_names, table = read_table(file)
    column(names, rows, name) = rows[:, findfirst(==(name), names)]
    verdicts = map(eachmatch(entry, read(joinpath(folder, "bounds.json"), String))) do found
        name = String(found[1])
        bound, horizon, scale = (parse(Float64, found[k]) for k in 2:4)
        name in own_names || return (name, "missing", "")
        both = [column(list, rows, each) for (list, rows) in ((names, right), (own_names, table)) for each in ("time", name)]
        return (name, judged_signal(bound + share * scale, horizon, both...)...)
    end
    all(each -> each[2] == "missing", verdicts) && throw(BadInput("$file: has none of the signals of $problem"))
    return verdicts
end

function main(arguments)
    length(arguments) in (2, 3) || (println(stderr, "julia check.jl PROBLEM FILE [SHARE]"); return 2)
    try
        verdicts = judged(arguments[1], arguments[2], something(tryparse(Float64, get(arguments, 3, "0")), NaN))
        foreach(each -> println(rpad(each[1], 18), " ", rpad(each[2], 18), " ", each[3]), verdicts)
        return any(each -> each[2] == "outside", verdicts) ? 1 : 0
    catch error
        println(stderr, error isa BadInput ? error.told : sprint(showerror, error))
        return 2
    end
end

end

abspath(PROGRAM_FILE) == @__FILE__() && exit(Pack.main(ARGS))
