#include "reference_scenes/reference.h"

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
#include <numbers>
#include <optional>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "images/replicates.h"
#include "includes.h"
#include "reference_scenes/child_process.h"
#include "reference_scenes/exporters.h"

namespace plumb {
namespace {

namespace fs = std::filesystem;
using Command = std::vector<std::string>;
using Json = nlohmann::json;

// POV-Ray has no samples or seeds; its scenes know the qualities themselves.
constexpr int samples_of_quality[] = {64, 256, 512};
constexpr int seeds_of_quality[] = {4, 4, 8};

constexpr const char* picture_name = "picture.exr";

constexpr const char* how_to_install[] = {
    "POV-Ray is not installed: 'apt-get install povray', or see povray.org",
    "Blender is not installed: 'apt-get install blender', or see blender.org",
    "python3 is not installed, which Mitsuba needs"};

// One run of the program, whose picture counts with `weight`.
struct Run {
  Command command;
  double weight = 1.0;
};

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

// What the programs are called with, and the folder in which they find and leave their files.
class Programs {
 public:
  Programs(const Scene& scene, const fs::path& scene_file, const ReferenceSettings& settings)
      : scene_(scene), settings_(settings) {
    switch (settings.program) {
      case Program::povray: export_to_povray(scene, folder_.path / "scene.pov"); break;
      case Program::cycles: export_to_cycles(scene, folder_.path / "scene.py"); break;
      case Program::mitsuba:
        write_file(folder_.path / "plumbline_mitsuba.py", mitsuba_include);
        scene_file_ = fs::absolute(scene_file);
        break;
    }
  }

  const fs::path& folder() const { return folder_.path; }
  fs::path picture() const { return folder_.path / picture_name; }

  // Those with up to the last bounce, less those without the first. What is in both isn't run.
  std::vector<Run> runs(int seed) const {
    const BounceRange& bounces = settings_.bounces;
    const bool is_open = bounces.last == BounceRange{}.last;
    std::vector<Run> runs = up_to(is_open ? std::nullopt : std::optional(bounces.last), seed);
    if (bounces.first == 0) return runs;
    for (Run& run : up_to(bounces.first - 1, seed)) {
      const auto same = std::ranges::find(runs, run.command, &Run::command);
      if (same == runs.end()) {
        runs.push_back({std::move(run.command), -run.weight});
      } else {
        runs.erase(same);
      }
    }
    return runs;
  }

 private:
  std::vector<Run> up_to(std::optional<int> bounces, int seed) const {
    if (settings_.program == Program::povray) return povray(bounces);
    // Blender looks where PWD says that it is.
    Command command =
        settings_.program == Program::cycles
            ? Command{"blender", "-b", "--factory-startup", "--python", folder_.path / "scene.py",
                      "--"}
            : Command{"python3", "plumbline_mitsuba.py", scene_file_};
    const auto add = [&](const std::string& option, const std::string& value) {
      command.insert(command.end(), {option, value});
    };
    add("-o", picture_name);
    add("--spp", std::to_string(settings_.samples_per_pixel));
    add("--seed", std::to_string(seed));
    add("--size", fmt::format("{}x{}", scene_.camera.width, scene_.camera.height));
    if (settings_.program == Program::mitsuba) {
      const double x_fov = 360.0 / std::numbers::pi * std::atan(scene_.camera.half_width());
      add("--x-fov", fmt::format("{}", x_fov));
    }
    if (bounces) add("--bounces", std::to_string(*bounces));
    if (settings_.threads > 0) add("--threads", std::to_string(settings_.threads));
    for (const std::string& setting : settings_.overrides) add("--set", setting);
    return {{command}};
  }

  // Lamps as the camera sees them, direct light from many points of the lamps, and what further
  // bounces add where the lamps have fewer points, which every gathered ray has to ask.
  std::vector<Run> povray(std::optional<int> bounces) const {
    constexpr std::array<int, 3> emission_depth{5, 9, 9};
    constexpr std::array<int, 3> direct_depth{3, 3, 5};
    constexpr std::array<int, 3> direct_grid{6, 8, 16};
    const auto quality = size_t(settings_.quality);
    std::vector<Run> runs{{povray(emission_depth[quality], 0, {})}};
    if (bounces == 0) return runs;
    runs.push_back({povray(direct_depth[quality], 1,
                           {"Emission=0", fmt::format("Lamp_grid={}", direct_grid[quality])})});
    if (bounces == 1) return runs;
    const Command coarse{"Emission=0", "Lamp_grid=4", "Lamp_detail=0",
                         fmt::format("Quality={}", quality)};
    runs.push_back({povray(3, bounces, coarse), 1.0});
    runs.push_back({povray(3, 1, coarse), -1.0});
    return runs;
  }

  // Anti-aliasing with `depth` x `depth` jittered rays in every pixel.
  Command povray(int depth, std::optional<int> bounces, const Command& declarations) const {
    Command command{"povray",
                    "+Iscene.pov",
                    fmt::format("+O{}", picture_name),
                    fmt::format("+W{}", scene_.camera.width),
                    fmt::format("+H{}", scene_.camera.height),
                    fmt::format("+R{}", depth)};
    command.insert(command.end(), {"+FE", "-D", "+A0.0", "+AM1", "+J1"});
    if (settings_.threads > 0) command.push_back(fmt::format("+WT{}", settings_.threads));
    if (bounces) command.push_back(fmt::format("Declare=Max_bounces={}", *bounces));
    for (const std::string& declaration : declarations) {
      command.push_back("Declare=" + declaration);
    }
    return command;
  }

  const Scene& scene_;
  const ReferenceSettings& settings_;
  Folder folder_;
  fs::path scene_file_;  // Mitsuba's
};

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

// What the program says of itself, in its log after "plumbline:" and as JSON. POV-Ray's scenes
// can't know the version and the seconds: they are in its own words.
Json read_report(const fs::path& log) {
  const std::string text = read_text(log);
  constexpr std::string_view mark = "plumbline:";
  const size_t begin = text.rfind(mark);
  if (begin == std::string::npos) throw std::runtime_error("the program left no report");
  std::istringstream rest(text.substr(begin + mark.size()));  // POV-Ray breaks long lines
  Json report;
  rest >> report;
  if (report.contains("seconds")) return report;
  std::smatch version;
  std::regex_search(text, version, std::regex(R"(Ray Tracer Version ([0-9.]*[0-9]))"));
  report["version"] = version.str(1);
  report["program"] = fmt::format("POV-Ray {}", version.str(1));
  double seconds = 0.0;
  const std::string times = text.substr(text.rfind("Render Time:"));
  const std::regex time(R"(\(([0-9.]+) seconds\))");
  for (std::sregex_iterator match(times.begin(), times.end(), time), end; match != end; ++match) {
    seconds += std::stod(match->str(1));
  }
  report["seconds"] = seconds;
  return report;
}

// Draws the scene seed by seed.
class Session {
 public:
  Session(const Scene& scene, const fs::path& scene_file, const ReferenceSettings& settings,
          const fs::path& log, const Watcher& watcher)
      : camera_(scene.camera),
        settings_(settings),
        programs_(scene, scene_file, settings_),
        log_(log),
        watcher_(watcher) {}

  void draw() {
    for (int i = 0; i < settings_.seeds && !watcher_.stop; ++i) {
      draw_seed(settings_.first_seed + i);
    }
    fs::remove(log_);
  }
  Reference result() const {
    if (pictures_.empty()) return {};
    const auto seeds = static_cast<int>(pictures_.size());
    return {image(),
            runs_[0].value("program", ""),
            runs_[0].value("version", ""),
            seeds,
            seeds * settings_.samples_per_pixel,
            wall_seconds_,
            process_seconds_,
            runs_.dump()};
  }

 private:
  void draw_seed(int seed) {
    std::vector<double> picture(size_t(camera_.width) * size_t(camera_.height) * 3);
    const std::vector<Run> runs = programs_.runs(seed);
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
    Json report = read_report(log_);
    wall_seconds_ += report["seconds"].get<double>();
    process_seconds_ += process.count();
    report["weight"] = run.weight;
    const std::string command = fmt::format("{}", fmt::join(run.command, " "));
    report["command"] =
        std::regex_replace(command, std::regex((programs_.folder() / "").string()), "");
    runs_.push_back(report);
    const std::vector<double> values = read_picture(programs_.picture(), camera_);
    for (size_t i = 0; i < values.size(); ++i) picture[i] += run.weight * values[i];
    fs::remove(programs_.picture());
  }

  int start(const Command& command, const std::string& which) {
    const auto show = [&](const std::string& line) {
      watcher_.show(fmt::format("{}, {}: {}", command[0], which, line));
    };
    try {
      return run_program(command, programs_.folder(), log_, show, watcher_.stop);
    } catch (const std::system_error& error) {
      if (error.code() != std::errc::no_such_file_or_directory) throw;
      fs::remove(log_);
      throw std::runtime_error(how_to_install[size_t(settings_.program)]);
    }
  }

  Image image() const {
    Image image{camera_.width, camera_.height, {"R", "G", "B"}, {}, {}};
    if (pictures_.size() > 1) {
      image.channels.insert(image.channels.end(), {"variance.R", "variance.G", "variance.B"});
    }
    for (size_t i = 0; i < pictures_[0].size(); i += 3) {
      std::array<double, 6> values{};  // as the channels
      for (size_t c = 0; c < 3; ++c) {
        Replicates<double> replicates;
        for (const auto& picture : pictures_) replicates.add(picture[i + c]);
        values[c] = replicates.mean;
        values[3 + c] = replicates.variance();
      }
      image.values.insert(image.values.end(), values.begin(),
                          values.begin() + std::ptrdiff_t(image.channels.size()));
    }
    return image;
  }

  const Camera& camera_;
  ReferenceSettings settings_;
  Programs programs_;
  fs::path log_;
  const Watcher& watcher_;
  std::vector<std::vector<double>> pictures_;
  Json runs_ = Json::array();
  double wall_seconds_ = 0.0;
  double process_seconds_ = 0.0;
};

void check_povray(const Scene& scene, const ReferenceSettings& settings) {
  if (settings.samples_per_pixel != 0 || settings.seeds != 0) {
    throw std::invalid_argument("POV-Ray has no samples or seeds, only qualities");
  }
  const auto is_mirror = [](const Shape& shape) {
    return shape.bsdf.kind == Bsdf::Kind::conductor;
  };
  if (!settings.bounces.is_everything() && std::ranges::any_of(scene.shapes, is_mirror)) {
    throw std::invalid_argument("POV-Ray can't count bounces in a scene with mirrors");
  }
}

ReferenceSettings complete(ReferenceSettings settings) {
  const auto quality = size_t(settings.quality);
  if (settings.samples_per_pixel == 0) settings.samples_per_pixel = samples_of_quality[quality];
  if (settings.seeds == 0) settings.seeds = seeds_of_quality[quality];
  if (settings.program == Program::povray) {
    settings.samples_per_pixel = 0;
    settings.seeds = 1;
  }
  return settings;
}

}  // namespace

std::string drawn_otherwise(const Scene& scene, Program program) {
  switch (program) {
    case Program::povray: return povray_filter_note(scene.camera);
    case Program::cycles: return cycles_filter_note(scene.camera);
    case Program::mitsuba: return "";
  }
  return "";
}

Reference render_reference(const Scene& scene, const fs::path& scene_file,
                           const ReferenceSettings& settings, const fs::path& log,
                           const Watcher& watcher) {
  if (settings.program == Program::povray) check_povray(scene, settings);
  if (settings.program != Program::cycles && !settings.overrides.empty()) {
    throw std::invalid_argument("only Cycles' own settings can be set");
  }
  Session session(scene, scene_file, complete(settings), log, watcher);
  session.draw();
  return session.result();
}

}  // namespace plumb
