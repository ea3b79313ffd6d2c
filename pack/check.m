function code = check(problem, file, share)
% Judges a table by the reference results of a problem: the rules of check.py, for MATLAB and Octave without toolboxes.
%
%   code = check('sag', 'mine.csv')      prints a line for each signal; 0: none is outside, 1: one is, 2: bad input
%   code = check('sag', 'mine.csv', 0.01)      adds a hundredth of each signal's largest value to its bound
%
% In a shell, from this folder: octave-cli --eval "exit(check('sag', 'mine.csv'))" or matlab -batch "exit(check('sag', 'mine.csv'))"
  try
    if nargin < 2
      error('check(problem, file, share)');
    elseif nargin < 3
      share = 0;
    end
    verdicts = judged(problem, file, share);
  catch problem_found
    fprintf(2, '%s\n', problem_found.message);
    code = 2;
    return
  end
  lines = verdicts';
  fprintf('%-18s %-18s %s\n', lines{:});
  code = double(any(strcmp(verdicts(:, 2), 'outside')));
end

function verdicts = judged(problem, file, share)
  folder = fullfile(fileparts(mfilename('fullpath')), problem);
  if ~isnumeric(share) || ~isscalar(share) || ~(share >= 0 && share <= 0.5)
    error('the share is a number from 0 to 0.5, such as 0.01 for one per cent');
  end
  if exist(fullfile(folder, 'bounds.json'), 'file') ~= 2
    error('%s: no such problem', problem);
  end
  % a line for each signal
  entry = '"(\w+)": \{"bound": ([^,]+), "horizon": ([^,]+), "scale": ([^,]+),';
  signals = regexp(fileread(fullfile(folder, 'bounds.json')), entry, 'tokens');
  right = read_table(fullfile(folder, 'results.csv'));
  own = read_table(file);
  verdicts = cell(numel(signals), 3);
  for k = 1:numel(signals)
    [name, numbers] = deal(signals{k}{1}, str2double(signals{k}(2:4)));
    verdicts(k, :) = {name, 'missing', ''};
    if isKey(own, name)
      pairs = {[right('time'), right(name)], [own('time'), own(name)]};
      [verdicts{k, 2:3}] = judged_signal(numbers(1) + share * numbers(3), numbers(2), pairs{:});
    end
  end
  if all(strcmp(verdicts(:, 2), 'missing'))
    error('%s: has none of the signals of %s', file, problem);
  end
end

function table = read_table(file)
% The columns of a CSV table by their names.
  if exist(file, 'file') ~= 2
    error('%s: cannot be read', file);
  end
  lines = regexp(fileread(file), '[^\r\n]+', 'match');
  lines = lines(~cellfun(@(line) isempty(strtrim(line)), lines));
  names = {};
  if ~isempty(lines)
    first = lines{1}(lines{1} >= ' ' & lines{1} <= '~');  % without the mark of UTF-8
    names = strrep(strtrim(regexp(first, ',', 'split')), '"', '');
  end
  named = names(~cellfun(@isempty, names));
  if ~any(strcmp(named, 'time')) || numel(unique(named)) < numel(named)
    error('%s: the first line must have `time` and each name once, separated by commas, without units', file);
  end
  rows = zeros(numel(lines) - 1, numel(names));
  for k = 1:numel(lines) - 1
    fields = strtrim(regexp(lines{k + 1}, ',', 'split'));
    if numel(fields) ~= numel(names)
      error('%s, row %d: %d fields, %d names', file, k + 1, numel(fields), numel(names));
    end
    fields(cellfun(@isempty, fields)) = {'nan'};
    rows(k, :) = str2double(fields);
    if any(isnan(rows(k, :)) & ~strcmpi(regexprep(fields, '^[+-]', ''), 'nan'))
      error('%s, row %d: not numbers: %s', file, k + 1, lines{k + 1});
    end
  end
  table = containers.Map(names, num2cell(rows, 1));
  if size(rows, 1) < 2 || ~all(diff(table('time')) > 0)
    error('%s: the times do not increase, or are fewer than two', file);
  end
end

function [status, told] = judged_signal(bound, horizon, right, own)
  [first, last] = deal(right(1, 1), right(end, 1));
  slack = 1e-9 * (last - first);
  own = own(own(:, 1) >= first - slack & own(:, 1) <= last + slack, :);
  errors = abs(own(:, 2) - arrayfun(@(t) interpolated(right(:, 1), right(:, 2), t), own(:, 1)));
  errors(~isfinite(errors)) = Inf;
  now = own(:, 1) <= horizon + slack;
  if ~any(now)
    [status, told] = deal('beyond the horizon', sprintf('no row from %g to %g s', first, horizon));
    return
  end
  status = 'outside';
  times = own(now, 1);
  marks = [first; times; horizon];
  gap = find(diff(marks) > (horizon - first) / 50 + slack, 1);
  [worst, at] = max(errors(now));
  later = find(~now & errors > bound, 1);
  if ~isempty(gap)
    told = sprintf('no row between %g and %g s; the horizon is %g s', marks(gap), marks(gap + 1), horizon);
  elseif worst > bound
    told = sprintf('off by %.2g at %g s, bound %.2g', worst, times(at), bound);
  elseif ~isempty(later)
    [status, told] = deal('beyond the horizon', sprintf('within up to %g s; off from %g s', horizon, own(later, 1)));
  else
    [status, told] = deal('within', sprintf('off by %.2g, bound %.2g', worst, bound));
  end
end

function value = interpolated(times, values, t)
% The value at t of the polynomial through the nearest six rows, by Lagrange's formula.
  first = min(max(sum(times <= t) - 2, 1), numel(times) - 5);
  rows = first:first + 5;
  value = 0;
  for i = rows
    others = rows(rows ~= i);
    value = value + values(i) * prod((t - times(others)) ./ (times(i) - times(others)));
  end
end
