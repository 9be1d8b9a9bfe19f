// SPDX-License-Identifier: Apache-2.0

#include "other_renderers/runner.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
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
#include "images/rgb.h"
#include "images/srgb.h"
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
  if (!renderer.script.empty()) write_file(folder / renderer.script_name, renderer.script);
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

// Radiance, of a value that the program has written.
float decode(float value, const Decoding& decoding) {
  switch (decoding.transfer) {
    case Decoding::Transfer::linear: break;
    case Decoding::Transfer::srgb: value = float(linear_of_srgb(double{value})); break;
    case Decoding::Transfer::gamma: value = std::pow(std::max(value, 0.0f), 2.2f); break;
  }
  return value * float(decoding.scale);
}

void check_numbers(const std::vector<float>& values, int width) {
  const auto is_bad = [](float value) { return !std::isfinite(value); };
  const auto first = std::ranges::find_if(values, is_bad);
  if (first == values.end()) return;
  const auto pixel = int(first - values.begin()) / 3;
  throw std::runtime_error(
      fmt::format("the program's picture has {} values that are infinite or no numbers, the first "
                  "of them in pixel {},{}",
                  std::ranges::count_if(values, is_bad), pixel % width, pixel / width));
}

// Values of R G B, pixel by pixel.
std::vector<float> read_picture(const fs::path& file, const Decoding& decoding,
                                const Camera& camera) {
  if (!fs::exists(file))
    throw std::runtime_error("the program left no " + file.filename().string());
  const Image image = read_image(file);
  const int width = camera.width, height = camera.height;
  if (image.width != width || image.height != height) {
    throw std::runtime_error(fmt::format("the program's picture is {}x{}, not {}x{} as the scene's",
                                         image.width, image.height, width, height));
  }
  const std::vector<float> values = rgb_of(image);
  if (values.empty()) throw std::runtime_error("the program's picture lacks R G B");
  check_numbers(values, width);
  std::vector<float> decoded;
  for_each_pixel({0, 0, width, height}, [&](int x, int y) {
    const size_t pixel =
        image.pixel(decoding.mirrored ? width - 1 - x : x, decoding.flipped ? height - 1 - y : y);
    for (size_t c = 0; c < 3; ++c) decoded.push_back(decode(values[pixel * 3 + c], decoding));
  });
  return decoded;
}

// What the program says of itself, in its log after "plumbline:" and as JSON; nothing if it need
// not.
Json read_report(const OtherRenderer& renderer, const fs::path& log) {
  std::ifstream stream(log);
  std::string text;
  for (std::string line; std::getline(stream, line);) {
    // POV-Ray's headings may get in between, from another thread.
    if (!line.starts_with("====")) text += line + "\n";
  }
  constexpr std::string_view mark = "plumbline:";
  const size_t begin = text.rfind(mark);
  if (begin == std::string::npos && !renderer.must_report) return Json::object();
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
  if (renderer.must_report && !report.value("seconds", Json()).is_number()) {
    throw std::runtime_error("the report lacks its seconds");
  }
  return report;
}

// The line of its probe that begins with its software's name, else the first; nothing if it can't
// be run.
std::optional<std::string> said_by(const OtherRenderer& renderer) {
  const Folder folder;
  const fs::path log = folder.path / "log";
  const std::atomic<bool> never{false};
  try {
    const auto show = [](const std::string&) {};
    if (run_program(renderer.probe, folder.path, log, show, never, 60.0) != 0) return {};
  } catch (const std::system_error&) {
    return {};
  }
  std::ifstream stream(log);
  std::string first;
  std::getline(stream, first);
  for (std::string line = first; stream; std::getline(stream, line)) {
    if (line.starts_with(renderer.software)) return line;
  }
  return first;
}

// For those whose program reads JSON and was given XML, as its last words tell.
std::string hint_at_format(const OtherRenderer& renderer, const std::string& line) {
  static const std::regex complaint("json|expected value|expecting value", std::regex::icase);
  if (renderer.format || !std::regex_search(line, complaint)) return "";
  return "; it was given Mitsuba's XML: if it reads plain numbers, its description needs scene = "
         "\"json\"";
}

// Draws the scene seed by seed.
struct Session {
  const OtherRenderer& renderer;
  const Scene& scene;
  const ReferenceSettings settings;
  const fs::path log;
  const Watcher& watcher;
  const Folder folder = {};
  fs::path file = {};  // that the renderer reads
  std::vector<Replicates<double>> values{size_t(scene.camera.width) * size_t(scene.camera.height) *
                                         3};
  const std::string version = renderer.must_report ? "" : said_by(renderer).value_or("");
  Json runs = Json::array();
  Reference reference = {};

  Reference draw(const fs::path& scene_file) {
    file = prepare(renderer, scene, scene_file, folder.path);
    for (int i = 0; i < settings.seeds && !watcher.stop; ++i) {
      draw_seed(settings.first_seed + i);
    }
    fs::remove(log);
    if (reference.seeds == 0) return {};
    reference.image = mean_of(values, scene.camera.width, scene.camera.height);
    reference.samples_per_pixel = reference.seeds * settings.samples_per_pixel;
    reference.runs = runs.dump();
    return reference;
  }

  void draw_seed(int seed) {
    std::vector<double> picture(values.size());
    const std::vector<Run> wanted = list_runs(renderer, {scene, file, settings, {}, seed});
    for (size_t i = 0; i < wanted.size() && !watcher.stop; ++i) {
      add(wanted[i],
          fmt::format("run {} of {}", size_t(reference.seeds) * wanted.size() + i + 1,
                      wanted.size() * size_t(settings.seeds)),
          picture);
    }
    if (watcher.stop) return;
    for (size_t i = 0; i < picture.size(); ++i) values[i].add(picture[i]);
    ++reference.seeds;
  }

  // Draws one picture and adds it, times the run's weight, to `picture`.
  void add(const Run& run, const std::string& which, std::vector<double>& picture) {
    const auto begin = std::chrono::steady_clock::now();
    const int status = start(run.command, which);
    if (watcher.stop) return;
    if (status != 0) {
      const std::string line = telling_line(log);
      throw std::runtime_error(fmt::format("{}: {} ({}; all that it said is in {}){}",
                                           renderer.name, line, name_of_end(status), log.string(),
                                           hint_at_format(renderer, line)));
    }
    const std::chrono::duration<double> process = std::chrono::steady_clock::now() - begin;
    Json report{{"program", renderer.name}, {"version", version}, {"seconds", process.count()}};
    report.update(read_report(renderer, log));
    reference.program = report.value("program", "");
    reference.version = report.value("version", "");
    reference.wall_seconds += report["seconds"].get<double>();
    reference.process_seconds += process.count();
    report["weight"] = run.weight;
    const std::string command = fmt::format("{}", fmt::join(run.command, " "));
    report["command"] = std::regex_replace(command, std::regex((folder.path / "").string()), "");
    runs.push_back(report);
    const fs::path drawn = folder.path / renderer.picture;
    const std::vector<float> light = read_picture(drawn, renderer.decoding, scene.camera);
    for (size_t i = 0; i < light.size(); ++i) picture[i] += run.weight * double{light[i]};
    fs::remove(drawn);
  }

  int start(const Command& command, const std::string& which) {
    const auto show = [&](const std::string& line) {
      watcher.show(fmt::format("{}, {}: {}", renderer.name, which, line));
    };
    try {
      return run_program(command, folder.path, log, show, watcher.stop, renderer.time_limit);
    } catch (const std::system_error& error) {
      if (error.code() != std::errc::no_such_file_or_directory) throw;
      fs::remove(log);
      throw std::runtime_error(renderer.how_to_install);
    }
  }
};

void check(const OtherRenderer& renderer, const Scene& scene, const ReferenceSettings& settings) {
  const auto refuse = [&](const std::string& why) {
    throw std::invalid_argument(renderer.name + " " + why);
  };
  if (!renderer.has_samples && (settings.samples_per_pixel != 0 || settings.seeds != 0)) {
    refuse("has no samples or seeds, only qualities");
  }
  const std::string obstacle = renderer.obstacle(scene);
  if (!obstacle.empty()) refuse(obstacle);
  if (!renderer.counts_bounces && !settings.bounces.is_everything()) {
    refuse("draws all light only, not some bounces of it");
  }
  const auto is_specular = [](const Shape& shape) { return shape.bsdf.is_specular(); };
  if (!renderer.counts_mirror_bounces && !settings.bounces.is_everything() &&
      std::ranges::any_of(scene.shapes, is_specular)) {
    refuse("can't count bounces in a scene with mirrors or glass");
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
  return Session{renderer, scene, complete(renderer, settings), log, watcher}.draw(scene_file);
}

Image mean_of(const std::vector<Replicates<double>>& values, int width, int height) {
  Image image{width, height, {"R", "G", "B"}, {}, {}};
  const bool knows_variance = values[0].count > 1;
  if (knows_variance) {
    image.channels.insert(image.channels.end(), {"variance.R", "variance.G", "variance.B"});
  }
  for (size_t i = 0; i < values.size(); i += 3) {
    for (size_t c = i; c < i + 3; ++c) image.values.push_back(float(values[c].mean));
    for (size_t c = i; c < i + 3 && knows_variance; ++c) {
      image.values.push_back(float(values[c].variance()));
    }
  }
  return image;
}

std::optional<std::string> installed_version(const OtherRenderer& renderer) {
  return said_by(renderer);
}

}  // namespace plumb
