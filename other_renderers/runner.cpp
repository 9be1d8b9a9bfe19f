#include "other_renderers/runner.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "images/output_file.h"
#include "images/replicates.h"
#include "other_renderers/child_process.h"
#include "other_renderers/export.h"

namespace plumb {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr int samples_of_quality[] = {64, 256, 512};
constexpr int seeds_of_quality[] = {4, 4, 8};

struct Folder {
  fs::path path;

  Folder() {
    std::string name = (fs::temp_directory_path() / "plumb-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) {
      throw std::system_error(errno, std::generic_category(), name);
    }
    path = name;
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
};

// The file that the renderer reads, after all that it reads was put into `folder`.
fs::path prepare(const OtherRenderer& renderer, const Scene& scene, const fs::path& scene_file,
                 const fs::path& folder) {
  if (renderer.format) {
    const fs::path file = folder / ("scene" + renderer.format->extension);
    export_scene(renderer, scene, file);
    return file;
  }
  write_file(folder / renderer.script_name, renderer.script);
  return fs::absolute(scene_file);
}

// Those with up to the last bounce, less those without the first. What is in both isn't run.
std::vector<Run> list_runs(const OtherRenderer& renderer, Job job) {
  const BounceRange& bounces = job.settings.bounces;
  const bool is_open = bounces.last == BounceRange{}.last;
  job.most_bounces = is_open ? std::nullopt : std::optional(bounces.last);
  std::vector<Run> runs = renderer.runs(job);
  if (bounces.first == 0) return runs;
  job.most_bounces = bounces.first - 1;
  for (Run& run : renderer.runs(job)) {
    const auto same = std::ranges::find(runs, run.command, &Run::command);
    if (same == runs.end()) {
      runs.push_back({std::move(run.command), -run.weight});
    } else {
      runs.erase(same);
    }
  }
  return runs;
}

// Values of R G B, pixel by pixel.
std::vector<double> read_picture(const fs::path& file, const Camera& camera) {
  const Image image = read_image(file);
  if (image.width != camera.width || image.height != camera.height) {
    throw std::runtime_error("the program's picture has another size than the scene's");
  }
  const auto red = std::ranges::find(image.channels, "R");
  if (image.channels.end() - red < 3) throw std::runtime_error("the program's picture lacks R G B");
  std::vector<double> values;
  for (size_t i = size_t(red - image.channels.begin()); i < image.values.size();
       i += image.channels.size()) {
    values.insert(values.end(), &image.values[i], &image.values[i] + 3);
  }
  return values;
}

std::string read_text(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// What the program says of itself, in its log after "plumbline:" and as JSON.
Json read_report(const OtherRenderer& renderer, const fs::path& log) {
  const std::string text = read_text(log);
  constexpr std::string_view mark = "plumbline:";
  const size_t begin = text.rfind(mark);
  if (begin == std::string::npos) throw std::runtime_error("the program left no report");
  std::istringstream rest(text.substr(begin + mark.size()));  // long lines may be broken
  Json report;
  rest >> report;
  if (renderer.read_log) {
    const RunReport said = renderer.read_log(text);
    report["program"] = said.program;
    report["version"] = said.version;
    report["seconds"] = said.seconds;
  }
  if (!report["seconds"].is_number()) throw std::runtime_error("the report lacks its seconds");
  return report;
}

// The mean of pictures, values of R G B, and from two on the variance of that mean.
Image mean_of(const std::vector<std::vector<double>>& pictures, int width, int height) {
  Image image{width, height, {"R", "G", "B"}, {}, {}};
  if (pictures.size() > 1) {
    image.channels.insert(image.channels.end(), {"variance.R", "variance.G", "variance.B"});
  }
  for (size_t i = 0; i < pictures[0].size(); i += 3) {
    std::array<double, 6> values{};  // as the channels
    for (size_t c = 0; c < 3; ++c) {
      Replicates<double> replicates;
      for (const auto& picture : pictures) replicates.add(picture[i + c]);
      values[c] = replicates.mean;
      values[3 + c] = replicates.variance();
    }
    image.values.insert(image.values.end(), values.begin(),
                        values.begin() + std::ptrdiff_t(image.channels.size()));
  }
  return image;
}

// Draws the scene seed by seed.
class Session {
 public:
  Session(const OtherRenderer& renderer, const Scene& scene, const fs::path& scene_file,
          const ReferenceSettings& settings, const fs::path& log, const Watcher& watcher)
      : renderer_(renderer),
        scene_(scene),
        settings_(settings),
        file_(prepare(renderer, scene, scene_file, folder_.path)),
        log_(log),
        watcher_(watcher) {}

  Reference draw() {
    for (int i = 0; i < settings_.seeds && !watcher_.stop; ++i) {
      draw_seed(settings_.first_seed + i);
    }
    fs::remove(log_);
    if (pictures_.empty()) return {};
    reference_.image = mean_of(pictures_, scene_.camera.width, scene_.camera.height);
    reference_.seeds = static_cast<int>(pictures_.size());
    reference_.samples_per_pixel = reference_.seeds * settings_.samples_per_pixel;
    reference_.runs = runs_.dump();
    return reference_;
  }

 private:
  void draw_seed(int seed) {
    const Camera& camera = scene_.camera;
    std::vector<double> picture(size_t(camera.width) * size_t(camera.height) * 3);
    const std::vector<Run> runs = list_runs(renderer_, {scene_, file_, settings_, {}, seed});
    for (size_t i = 0; i < runs.size() && !watcher_.stop; ++i) {
      add(runs[i],
          fmt::format("run {} of {}", pictures_.size() * runs.size() + i + 1,
                      runs.size() * size_t(settings_.seeds)),
          picture);
    }
    if (!watcher_.stop) pictures_.push_back(std::move(picture));
  }

  // Draws one picture and adds it, times the run's weight, to `picture`.
  void add(const Run& run, const std::string& which, std::vector<double>& picture) {
    const auto begin = std::chrono::steady_clock::now();
    const int status = start(run.command, which);
    if (watcher_.stop) return;
    if (status != 0) {
      throw std::runtime_error(fmt::format("{}: {} ({}; all that it said is in {})", run.command[0],
                                           telling_line(log_), name_of_end(status), log_.string()));
    }
    const std::chrono::duration<double> process = std::chrono::steady_clock::now() - begin;
    Json report = read_report(renderer_, log_);
    reference_.program = report.value("program", "");
    reference_.version = report.value("version", "");
    reference_.wall_seconds += report["seconds"].get<double>();
    reference_.process_seconds += process.count();
    report["weight"] = run.weight;
    const std::string command = fmt::format("{}", fmt::join(run.command, " "));
    report["command"] = std::regex_replace(command, std::regex((folder_.path / "").string()), "");
    runs_.push_back(report);
    const fs::path file = folder_.path / picture_name;
    const std::vector<double> values = read_picture(file, scene_.camera);
    for (size_t i = 0; i < values.size(); ++i) picture[i] += run.weight * values[i];
    fs::remove(file);
  }

  int start(const Command& command, const std::string& which) {
    const auto show = [&](const std::string& line) {
      watcher_.show(fmt::format("{}, {}: {}", command[0], which, line));
    };
    try {
      return run_program(command, folder_.path, log_, show, watcher_.stop);
    } catch (const std::system_error& error) {
      if (error.code() != std::errc::no_such_file_or_directory) throw;
      fs::remove(log_);
      throw std::runtime_error(renderer_.how_to_install);
    }
  }

  const OtherRenderer& renderer_;
  const Scene& scene_;
  ReferenceSettings settings_;
  Folder folder_;
  fs::path file_;  // that the renderer reads
  fs::path log_;
  const Watcher& watcher_;
  std::vector<std::vector<double>> pictures_;
  Json runs_ = Json::array();
  Reference reference_;
};

void check(const OtherRenderer& renderer, const Scene& scene, const ReferenceSettings& settings) {
  const auto refuse = [&](const std::string& why) {
    throw std::invalid_argument(renderer.name + " " + why);
  };
  if (!renderer.has_samples && (settings.samples_per_pixel != 0 || settings.seeds != 0)) {
    refuse("has no samples or seeds, only qualities");
  }
  const auto is_mirror = [](const Shape& shape) {
    return shape.bsdf.kind == Bsdf::Kind::conductor;
  };
  if (!renderer.counts_mirror_bounces && !settings.bounces.is_everything() &&
      std::ranges::any_of(scene.shapes, is_mirror)) {
    refuse("can't count bounces in a scene with mirrors");
  }
  if (renderer.example_setting.empty() && !settings.overrides.empty()) {
    refuse("has no settings of its own that can be set");
  }
}

ReferenceSettings complete(const OtherRenderer& renderer, ReferenceSettings settings) {
  const auto quality = size_t(settings.quality);
  if (settings.samples_per_pixel == 0) settings.samples_per_pixel = samples_of_quality[quality];
  if (settings.seeds == 0) settings.seeds = seeds_of_quality[quality];
  if (!renderer.has_samples) {
    settings.samples_per_pixel = 0;
    settings.seeds = 1;
  }
  return settings;
}

}  // namespace

Reference render_reference(const OtherRenderer& renderer, const Scene& scene,
                           const fs::path& scene_file, const ReferenceSettings& settings,
                           const fs::path& log, const Watcher& watcher) {
  check(renderer, scene, settings);
  return Session(renderer, scene, scene_file, complete(renderer, settings), log, watcher).draw();
}

bool is_installed(const OtherRenderer& renderer) {
  const Folder folder;
  const std::atomic<bool> never{false};
  try {
    const auto show = [](const std::string&) {};
    return run_program(renderer.probe, folder.path, folder.path / "log", show, never) == 0;
  } catch (const std::system_error&) {
    return false;
  }
}

}  // namespace plumb
