// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include <gflags/gflags.h>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"
#include "prism/report/plot.h"
#include "tools/bench_process.h"
#include "tools/bench_results.h"
#include "tools/bench_speed.h"
#include "tools/bench_suite.h"
#include "tools/machine.h"
#include "tools/tool_main.h"

DEFINE_string(suite, "", "Suite file (YAML, see sequences/SUITES.md)");
DEFINE_string(output_dir, "", "Folder of the runs and of the results");
DEFINE_string(data_dir, "../shared/data", "What {data} in the suite stands for");
DEFINE_string(program, "", "The odometry to run; default: prism_vo beside this program");
DEFINE_int32(repeat,
             0,
             "Seeds 0 to N-1 instead of those of the suite; 0: those of the suite. With --speed: "
             "times each run is measured; 0: five");
DEFINE_bool(
    speed,
    false,
    "Measure how fast each sequence and variant is, by the first seed again and again after "
    "a run to warm up: speed.txt and speed.json instead of errors");
DEFINE_string(filter, "", "Only runs whose sequence/variant/seed contains this");
DEFINE_bool(list_jobs, false, "List the runs, one a line, and end");
DEFINE_int32(job, -1, "Run only this one of the list, without tables and plots");
DEFINE_bool(retry_failed, false, "Run again what failed before");
DEFINE_string(baseline, "", "Folder of another suite's results to compare with");

namespace prism {
namespace {

namespace fs = std::filesystem;

std::string InOutput(const std::string& name) {
  return (fs::path(FLAGS_output_dir) / name).string();
}

std::string ProgramPath() {
  if (!FLAGS_program.empty()) return FLAGS_program;
  return (fs::read_symlink("/proc/self/exe").parent_path() / "prism_vo").string();
}

std::string FolderOf(const BenchJob& job) { return InOutput("runs/" + job.name()); }
std::string ResultPath(const BenchJob& job) { return FolderOf(job) + "/result.json"; }

// The result of a run that ended before, if the same command was run.
bool ReadEarlier(const BenchJob& job, BenchResult* result) {
  if (!fs::exists(ResultPath(job))) return false;
  *result = BenchResult::parse(ReadTextFile(ResultPath(job)), nullptr, false);
  if (result->is_discarded() || (*result)["command"] != BenchResult(job.arguments)) return false;
  return !FLAGS_retry_failed || (*result)["status"] == "done";
}

BenchResult RunJob(const BenchSuite& suite, const BenchJob& job) {
  const std::string folder = FolderOf(job);
  fs::remove_all(folder);
  CreateDirectory(folder);
  std::vector<std::string> command = {ProgramPath()};
  command.insert(command.end(), job.arguments.begin(), job.arguments.end());
  command.push_back("--output_dir=" + folder);
  const ProcessOutcome outcome =
      RunProcess(command, folder + "/log.txt", suite.time_limit_s, suite.memory_limit_mib);
  BenchResult result = CollectResult(job, outcome, folder);
  WriteTextAtomically(ResultPath(job), result.dump() + "\n");
  return result;
}

// The ground truth of a sequence: the flag's, or the sequence's own.
std::string GroundtruthPath(const BenchSuite& suite, const BenchSequence& sequence) {
  FlagMap flags = suite.flags;
  for (const auto& [name, value] : sequence.flags) flags[name] = value;
  if (flags.count("groundtruth") > 0) return flags["groundtruth"];
  if (flags.count("sequence") > 0)
    return (fs::path(flags["sequence"]) / "groundtruth.txt").string();
  throw InputError(FLAGS_suite,
                   "no flag groundtruth of " + sequence.name,
                   "one, to evaluate trajectories of other systems");
}

// Trajectories of other systems. Read before anything runs: a mistake in the suite shows at once.
std::vector<BenchResult> EvaluateExternals(const BenchSuite& suite) {
  std::vector<BenchResult> results;
  for (const BenchExternal& external : suite.external) {
    for (const BenchSequence& sequence : suite.sequences) {
      if (sequence.name != external.sequence) continue;
      results.push_back(EvaluateExternal(external, GroundtruthPath(suite, sequence)));
    }
  }
  return results;
}

// Runs or takes over every job; appends a line to results.jsonl after each, and those of other
// systems at the end.
std::vector<BenchResult> RunJobs(const BenchSuite& suite,
                                 const std::vector<BenchJob>& jobs,
                                 std::vector<BenchResult> external) {
  std::vector<BenchResult> results;
  std::ofstream lines(InOutput("results.jsonl"), std::ios::trunc);
  for (size_t i = 0; i < jobs.size(); ++i) {
    BenchResult result;
    const bool is_earlier = ReadEarlier(jobs[i], &result);
    if (!is_earlier) result = RunJob(suite, jobs[i]);
    lines << result.dump() << std::endl;
    std::cout << i + 1 << "/" << jobs.size() << " " << jobs[i].name() << ": "
              << result["status"].get<std::string>() << (is_earlier ? " (before)" : "")
              << std::endl;
    results.push_back(std::move(result));
  }
  for (BenchResult& result : external) {
    lines << result.dump() << std::endl;
    results.push_back(std::move(result));
  }
  if (!lines) throw InputError(InOutput("results.jsonl"), "an error on writing", "space left");
  return results;
}

std::string EscapedHtml(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    escaped += c == '&' ? "&amp;" : c == '<' ? "&lt;" : std::string(1, c);
  }
  return escaped;
}

// Tables and plots in one page without scripts.
void WriteSuiteReport(const std::vector<std::pair<std::string, std::string>>& tables,
                      const std::vector<std::string>& plots) {
  std::string page =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"
      "<meta name=\"color-scheme\" content=\"light dark\"><link rel=\"icon\" href=\"data:,\">"
      "<title>PRISM-VO suite</title><style>body{font:16px/1.4 system-ui,sans-serif;margin:1rem}"
      "pre{overflow-x:auto}svg{max-width:100%;height:auto}</style></head><body>\n<h1>" +
      EscapedHtml(FLAGS_suite) + "</h1>\n";
  for (const auto& [title, table] : tables) {
    if (table.empty()) continue;
    page += "<h2>" + title + "</h2>\n<pre>" + EscapedHtml(table) + "</pre>\n";
  }
  page += "<h2>Cumulative errors</h2>\n";
  for (const std::string& plot : plots) page += ReadTextFile(plot);
  WriteTextAtomically(InOutput("report.html"), page + "</body></html>\n");
}

// `baseline`: results to compare with; empty: none.
void Summarize(const std::vector<BenchResult>& results, const std::vector<BenchResult>& baseline) {
  std::vector<std::pair<std::string, std::string>> tables = {
      {"Medians over the runs", FormatResultTable(results)},
      {"Stage times", FormatStageTable(results)}};
  std::vector<BenchResult> plotted = results;
  if (!baseline.empty()) {
    tables.emplace_back("Against " + FLAGS_baseline, FormatComparison(results, baseline));
    for (BenchResult result : baseline) {
      result["variant"] = result["variant"].get<std::string>() + " (before)";
      plotted.push_back(std::move(result));
    }
  }
  std::string text;
  for (const auto& [title, table] : tables) text += "\n" + title + "\n" + table;
  std::cout << text;
  WriteTextAtomically(InOutput("table.txt"), text.substr(1));

  std::vector<std::string> plots;
  const std::pair<const char*, const char*> errors[] = {{"ate_rmse_m", "ATE (m)"},
                                                        {"e_s", "scale drift e_s"},
                                                        {"e_r_deg", "rotation drift e_r (deg)"},
                                                        {"e_align_m", "alignment error (m)"},
                                                        {"d_s", "absolute scale error d_s"}};
  for (const auto& [key, label] : errors) {
    const std::string path = InOutput(std::string("cumulative_") + key);
    WritePlot(path, CumulativePlot(plotted, key, label));
    plots.push_back(path + ".svg");
  }
  WriteSuiteReport(tables, plots);
}

// The same run, `count` times after one that is not looked at; ends with the first that fails.
std::vector<BenchResult> RepeatJob(const BenchSuite& suite, const BenchJob& job, int count) {
  std::vector<BenchResult> results;
  for (int i = 0; i <= count; ++i) {
    BenchResult result = RunJob(suite, job);
    const bool is_done = result["status"] == "done";
    std::cout << job.sequence << "/" << job.variant << ", "
              << (i == 0 ? "to warm up" : std::to_string(i) + " of " + std::to_string(count))
              << ": " << result["status"].get<std::string>() << std::endl;
    if (!is_done) return {std::move(result)};
    if (i > 0) results.push_back(std::move(result));
  }
  return results;
}

ExitStatus MeasureSpeed(const BenchSuite& suite, const std::vector<BenchJob>& jobs) {
  const Machine machine = ThisMachine();
  std::string text = FormatMachine(machine);
  nlohmann::ordered_json json = {{"machine", MachineToJson(machine)}, {"suite", FLAGS_suite}};
  json["runs"] = nlohmann::ordered_json::array();
  std::string failed;
  for (const BenchJob& job : jobs) {
    const std::vector<BenchResult> results =
        RepeatJob(suite, job, FLAGS_repeat > 0 ? FLAGS_repeat : 5);
    if (results.back()["status"] != "done") {
      failed = FolderOf(job);
      continue;
    }
    json["runs"].push_back(SummarizeSpeed(results));
    text += "\n" + FormatSpeed(json["runs"].back());
  }
  std::cout << "\n" << text;
  WriteTextAtomically(InOutput("speed.txt"), text);
  WriteTextAtomically(InOutput("speed.json"), json.dump(1) + "\n");
  if (failed.empty()) return kExitDone;
  std::cerr << "prism_bench: " << FLAGS_suite << ": found a run that failed, expected none (see "
            << failed << "/log.txt)" << std::endl;
  return kExitRunFailed;
}

ExitStatus Run() {
  RequireFlag("suite", FLAGS_suite, "a suite file");
  BenchSuite suite = ReadBenchSuite(FLAGS_suite, FLAGS_data_dir);
  if (FLAGS_speed) {
    suite.seeds.resize(1);
  } else if (FLAGS_repeat > 0) {
    suite.seeds.resize(static_cast<size_t>(FLAGS_repeat));
    for (int i = 0; i < FLAGS_repeat; ++i) suite.seeds[static_cast<size_t>(i)] = i;
  }
  std::vector<BenchJob> jobs;
  for (BenchJob& job : ListJobs(suite)) {
    if (job.name().find(FLAGS_filter) != std::string::npos) jobs.push_back(std::move(job));
  }
  if (jobs.empty()) throw InputError("--filter", "no run with '" + FLAGS_filter + "'", "one");
  if (FLAGS_list_jobs) {
    for (size_t i = 0; i < jobs.size(); ++i) std::cout << i << " " << jobs[i].name() << "\n";
    return kExitDone;
  }
  RequireFlag("output_dir", FLAGS_output_dir, "a folder for the results");
  if (access(ProgramPath().c_str(), X_OK) != 0) {
    throw InputError("--program", "no program " + ProgramPath(), "the odometry to run");
  }
  if (FLAGS_speed && (FLAGS_job >= 0 || !FLAGS_baseline.empty())) {
    throw InputError("--speed", "--job or --baseline beside it", "neither");
  }
  CreateDirectory(FLAGS_output_dir);
  if (FLAGS_speed) return MeasureSpeed(suite, jobs);
  if (FLAGS_job >= 0) {
    if (FLAGS_job >= static_cast<int>(jobs.size())) {
      throw InputError("--job",
                       std::to_string(FLAGS_job),
                       "0 to " + std::to_string(jobs.size() - 1) + " (see --list_jobs)");
    }
    const BenchJob& job = jobs[static_cast<size_t>(FLAGS_job)];
    BenchResult result;
    if (!ReadEarlier(job, &result)) result = RunJob(suite, job);
    std::cout << job.name() << ": " << result["status"].get<std::string>() << "\n";
    return kExitDone;
  }
  std::vector<BenchResult> baseline;
  if (!FLAGS_baseline.empty()) {
    baseline = ReadResults((fs::path(FLAGS_baseline) / "results.jsonl").string());
  }
  const std::vector<BenchResult> results = RunJobs(suite, jobs, EvaluateExternals(suite));
  Summarize(results, baseline);
  const bool any_done = std::any_of(results.begin(), results.end(), [](const BenchResult& result) {
    return result["status"] == "done";
  });
  if (any_done) return kExitDone;
  std::cerr << "prism_bench: " << FLAGS_suite << ": found no run that succeeded, expected one (see "
            << FolderOf(jobs.front()) << "/log.txt)" << std::endl;
  return kExitRunFailed;
}

}  // namespace
}  // namespace prism

int main(int argc, char** argv) {
  return prism::RunTool(
      {"prism_bench",
       "runs a suite of sequences, variants and seeds and compares the results",
       "--suite=FILE --output_dir=FOLDER [--baseline=FOLDER] [--list_jobs] [--job=N]\n"
       "       prism_bench --speed --suite=FILE --output_dir=FOLDER [--repeat=N]",
       "prism_bench --suite=sequences/redkitchen_ablation.yaml --output_dir=out/ablation"},
      argc,
      argv,
      prism::Run);
}
