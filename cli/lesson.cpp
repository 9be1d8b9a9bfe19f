// SPDX-License-Identifier: Apache-2.0

#include "cli/lesson.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "compare/plot.h"
#include "images/image.h"
#include "images/srgb.h"
#include "radiosity/eye.h"
#include "radiosity/faces.h"
#include "radiosity/radiosity.h"
#include "radiosity/solution.h"
#include "radiosity/teaching/exchange.h"
#include "radiosity/teaching/film.h"
#include "radiosity/teaching/form_factors.h"
#include "radiosity/teaching/patches.h"

namespace plumb::cli {
namespace {

using namespace radiosity;
using namespace radiosity::teaching;
using nlohmann::ordered_json;

constexpr size_t usual_count = 1000;  // of patches

struct Tile {
  int width, height;
  std::vector<float> rgb;
};

ordered_json to_json(const Rgb& value) { return {value.x, value.y, value.z}; }

// What one row gives to other patches than the other one does.
double misplaced(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum / 2.0;
}

class Lesson {
 public:
  Lesson(const Scene& scene, const Faces& faces, std::filesystem::path folder, double exposure,
         size_t most_bytes, const Work& work)
      : scene_(scene),
        folder_(std::move(folder)),
        exposure_(exposure),
        most_bytes_(most_bytes),
        work_(work),
        faces_(faces),
        patches_(mesh(usual_count, true)),
        raw_(form_factors(patches_, work)),
        exchange_(patches_, raw_, work),
        film_(patches_, scene.camera, work),
        exact_(exchange_.light()) {}

  void give() {
    show_form_factors();
    show_hemicubes();
    show_bounces();
    show_shooting();
    show_sweeps();
    show_leaks();
    show_meshes();
  }

 private:
  Patches mesh(size_t count, bool is_cut) const {
    const double most = std::sqrt(double(most_bytes_) / sizeof(double));
    return Patches::of_about(faces_, count, is_cut, size_t(most));
  }

  void write_strip(const std::string& name, const std::vector<Tile>& tiles, size_t columns,
                   double exposure) const;
  void write_numbers(const std::string& part, ordered_json numbers) {
    numbers_[part] = std::move(numbers);
    write_file(folder_ / "lesson.json", numbers_.dump(1) + "\n");
  }
  // And plots columns of them, which have these titles, against another one.
  void write_plot(const std::string& part, ordered_json rows, const std::string& title,
                  const std::pair<std::string, std::string>& x,
                  const std::vector<std::pair<std::string, std::string>>& columns);
  Tile tile(std::vector<float> rgb) const {
    return {scene_.camera.width, scene_.camera.height, std::move(rgb)};
  }

  struct Sight {
    Vec3 direction;  // from the camera
    Rgb radiance;
  };

  size_t shown_patch() const;
  Tile matrix() const;
  void show_form_factors();
  void show_hemicubes();
  void show_bounces();
  void show_shooting();
  void show_sweeps();
  void show_leaks();
  std::vector<Sight> sights() const;
  std::pair<double, double> errors(const Patches& patches, const Light& light,
                                   const std::vector<Sight>& sights) const;
  void show_meshes();

  const Scene& scene_;
  std::filesystem::path folder_;
  double exposure_;
  size_t most_bytes_;
  const Work& work_;
  const Faces& faces_;
  Patches patches_;
  FormFactors raw_;
  Exchange exchange_;
  Film film_;
  Light exact_;
  ordered_json numbers_;
};

void Lesson::write_strip(const std::string& name, const std::vector<Tile>& tiles, size_t columns,
                         double exposure) const {
  constexpr int gap = 4;
  const int width = tiles[0].width + gap, height = tiles[0].height + gap;
  const auto rows = static_cast<int>((tiles.size() + columns - 1) / columns);
  Image image{width * int(columns) - gap, height * rows - gap, {"R", "G", "B"}, {}, {}};
  image.values.resize(size_t(image.width * image.height * 3));
  for (size_t i = 0; i < tiles.size(); ++i) {
    const Tile& from = tiles[i];
    const int left = int(i % columns) * width, top = int(i / columns) * height;
    for (int y = 0; y < from.height; ++y) {
      std::copy_n(&from.rgb[size_t(y * from.width * 3)], from.width * 3,
                  &image.values[image.pixel(left, top + y) * 3]);
    }
  }
  write_image(image, folder_ / (name + ".png"), exposure);
}

void Lesson::write_plot(const std::string& part, ordered_json rows, const std::string& title,
                        const std::pair<std::string, std::string>& x,
                        const std::vector<std::pair<std::string, std::string>>& columns) {
  std::vector<Curve> curves;
  for (const auto& [column, name] : columns) {
    curves.push_back({name, {}, {}});
    for (const auto& row : rows) {
      const double y = row[column];
      curves.back().points.push_back({row[x.first], y, y, y});
    }
  }
  plumb::write_plot({title, x.second, "error", curves, {}}, folder_ / (part + ".svg"));
  write_numbers(part, std::move(rows));
}

// Above the middle of the picture.
size_t Lesson::shown_patch() const {
  const Camera& camera = scene_.camera;
  const auto hit =
      patches_.trace(camera.origin, camera.direction(0.5 * camera.width, 0.35 * camera.height));
  return hit ? hit->patch : 0;
}

// Decades of grey, with the patches' colours at its left and above.
Tile Lesson::matrix() const {
  constexpr size_t largest = 400, band = 8;
  constexpr double least = -2.0, most = 1.5;  // powers of ten, in parts of the mean
  const size_t size = raw_.size(), block = (size + largest - 1) / largest, cells = size / block;
  const size_t width = cells + band;
  Tile picture{int(width), int(width), std::vector<float>(width * width * 3)};
  const auto set = [&](size_t x, size_t y, const Rgb& value) {
    for (size_t c = 0; c < 3; ++c) picture.rgb[(y * width + x) * 3 + c] = float(value[int(c)]);
  };
  for (size_t row = 0; row < cells; ++row) {
    const Face& face = faces_[patches_[row * block].face];
    const Rgb colour = face.is_lamp() ? Rgb(1.0) : face.reflectance;
    for (size_t k = 0; k < band; ++k) {
      set(k, row + band, colour);
      set(row + band, k, colour);
    }
    for (size_t column = 0; column < cells; ++column) {
      double sum = 0.0;
      for (size_t i = 0; i < block; ++i) {
        const auto part = raw_.row(row * block + i).subspan(column * block, block);
        sum += std::accumulate(part.begin(), part.end(), 0.0);
      }
      const double power = std::log10(sum / double(block * block) * double(size));
      const double code = (power - least) / (most - least);
      set(column + band, row + band, Rgb(linear_of_srgb(std::clamp(code, 0.0, 1.0))));
    }
  }
  return picture;
}

void Lesson::show_form_factors() {
  write_strip("matrix", {matrix()}, 1, 0.0);
  const size_t shown = shown_patch();
  Light row(patches_.size());
  double most = 0.0;
  for (size_t j = 0; j < row.size(); ++j) {
    row[j] = Rgb(raw_.row(shown)[j] / patches_[j].whole);
    most = std::max(most, row[j].x);
  }
  for (Rgb& value : row) value /= most;
  row[shown] = Rgb(1.0, 0.1, 0.1);
  write_strip("row", {tile(film_.flat(row))}, 1, 0.0);

  // A row must add up to what the whole faces say, at the same points.
  double off = 0.0, least = 1.0, greatest = 0.0, changed = 0.0, sum = 0.0, off_after = 0.0;
  Eye eye(faces_);
  for (size_t i = 0; i < patches_.size(); ++i) {
    work_.check();
    const Element& patch = patches_[i];
    double whole = 0.0;
    for (size_t q = 0; q < size_t(patch.points); ++q) {
      eye.move_to(patch.face, patch.point[q]);
      for (size_t face = 0; face < faces_.list().size(); ++face) {
        whole += eye.form_factor_of(face) * patch.area[q] / patch.whole;
      }
    }
    off = std::max(off, std::abs(raw_.row_sum(i) - whole));
    off_after = std::max(off_after, std::abs(exchange_.factors.row_sum(i) - whole));
    least = std::min(least, whole);
    greatest = std::max(greatest, whole);
    sum += patch.whole * whole;
    for (size_t j = 0; j < patches_.size(); ++j) {
      changed += patch.whole * std::abs(raw_.row(i)[j] - exchange_.factors.row(i)[j]);
    }
  }
  const auto lack = [&](const FormFactors& factors) {
    return lack_of_reciprocity(factors, exchange_.areas);
  };
  write_numbers("form_factors", {{"patches", patches_.size()},
                                 {"row_sums", {least, greatest}},
                                 {"row_sum_error", off},
                                 {"lack_of_reciprocity", lack(raw_)},
                                 {"changed", changed / sum},
                                 {"row_sum_error_after", off_after},
                                 {"lack_of_reciprocity_after", lack(exchange_.factors)}});
}

void Lesson::show_hemicubes() {
  constexpr size_t judges = 16;
  const size_t shown = shown_patch();
  const Hemicube large(patches_, shown, 128);
  Tile unfolded{256, 256, std::vector<float>(size_t{3} * 256 * 256)};
  for (size_t i = 0; i < large.cells().size(); ++i) {
    if (large.cells()[i] == Hemicube::nothing) continue;
    for (size_t c = 0; c < 3; ++c)
      unfolded.rgb[i * 3 + c] = float(exact_[large.cells()[i]][int(c)]);
  }
  write_strip("hemicube", {unfolded}, 1, exposure_);

  ordered_json rows = ordered_json::array();
  for (int resolution = 8; resolution <= 256; resolution *= 2) {
    double error = 0.0, of_middle = 0.0;
    for (size_t k = 0; k < judges; ++k) {
      work_.show(fmt::format("hemicubes of {} cells, {} %", resolution, 100 * k / judges));
      work_.check();
      const size_t i = (2 * k + 1) * patches_.size() / (2 * judges);
      const auto exact = point_factors(patches_, patches_[i].face, patches_[i].center);
      const auto row = raw_.row(i);
      const auto found = Hemicube(patches_, i, resolution).factors(patches_.size());
      error += misplaced(found, exact) / judges;
      of_middle += misplaced({row.begin(), row.end()}, exact) / judges;
    }
    rows.push_back({{"resolution", resolution}, {"error", error}, {"middle", of_middle}});
  }
  write_plot("hemicubes", rows, "Light that a hemicube sends to wrong patches",
             {"resolution", "cells along an edge"},
             {{"error", "hemicube"}, {"middle", "exact, but from the patch's middle"}});
}

void Lesson::show_bounces() {
  constexpr int most = 20, shown = 6;
  std::vector<Tile> tiles;
  ordered_json rows = ordered_json::array();
  Light last = exchange_.emission, sum(last.size(), Rgb(0.0));
  const auto power = [&](const Light& light) {
    Rgb whole(0.0);
    for (size_t i = 0; i < light.size(); ++i) whole += light[i] * exchange_.areas[i];
    return whole;
  };
  const Rgb all = power(exact_);
  Rgb before(0.0);
  for (int bounce = 0; bounce <= most; ++bounce) {
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += last[i];
    if (bounce < shown) tiles.push_back(tile(film_.flat(sum)));
    const Rgb now = power(last);
    ordered_json row{{"bounce", bounce}, {"share", to_json(now / all)}};
    if (bounce > 0) row["ratio"] = to_json(now / before);
    rows.push_back(row);
    before = now;
    last = exchange_.reflect(last);
  }
  write_strip("bounces", tiles, 3, exposure_);
  write_numbers("bounces", {{"rows", rows},
                            {"spectral_radius", to_json(exchange_.spectral_radius())},
                            {"bound", to_json(exchange_.bound())}});
}

void Lesson::show_shooting() {
  std::vector<Tile> plain, ambient;
  ordered_json rows = ordered_json::array();
  Shooting shooting(exchange_);
  size_t shown = 1, next = 1;
  const double emitted = shooting.unshot_power();
  for (size_t shot = 1; shot <= 10 * patches_.size(); ++shot) {
    work_.check();
    shooting.shoot();
    const bool is_shown = shot == shown && shot <= usual_count;
    if (is_shown) {
      shown *= 10;
      plain.push_back(tile(film_.flat(shooting.light())));
      ambient.push_back(tile(film_.flat(shooting.with_ambient())));
    }
    if (shot < next && !is_shown) continue;
    next = std::max(shot + 1, shot * 5 / 4);
    rows.push_back({{"shots", shot},
                    {"error", exchange_.error(shooting.light(), exact_)},
                    {"with_ambient", exchange_.error(shooting.with_ambient(), exact_)},
                    {"unshot", shooting.unshot_power() / emitted}});
  }
  plain.insert(plain.end(), ambient.begin(), ambient.end());
  write_strip("shooting", plain, plain.size() / 2, exposure_);
  write_plot("shooting", rows, "Progressive refinement", {"shots", "shots"},
             {{"error", "what was sent"}, {"with_ambient", "and the ambient term"}});
}

void Lesson::show_sweeps() {
  constexpr int most = 30;
  Light gathered = exchange_.emission, in_place = gathered;
  Shooting shooting(exchange_);
  ordered_json rows = ordered_json::array();
  for (int sweep = 1; sweep <= most; ++sweep) {
    exchange_.jacobi(gathered);
    exchange_.gauss_seidel(in_place);
    for (size_t i = 0; i < patches_.size(); ++i) shooting.shoot();
    rows.push_back({{"sweeps", sweep},
                    {"jacobi", exchange_.error(gathered, exact_)},
                    {"gauss_seidel", exchange_.error(in_place, exact_)},
                    {"shooting", exchange_.error(shooting.light(), exact_)}});
  }
  write_plot("sweeps", rows, "Gathering and shooting", {"sweeps", "sweeps"},
             {{"jacobi", "gathering (Jacobi)"},
              {"gauss_seidel", "gathering in place (Gauss-Seidel)"},
              {"shooting", "shooting, as many shots as patches"}});
}

// Looks closer at where two pictures differ most.
Camera towards_difference(const Camera& camera, const std::vector<float>& a,
                          const std::vector<float>& b) {
  constexpr double closer = 3.0;
  constexpr int side = 8;
  const int columns = std::max(1, camera.width / side), rows = std::max(1, camera.height / side);
  std::vector<double> differences(size_t(columns * rows), 0.0);
  for (size_t i = 0; i < a.size(); ++i) {
    const auto pixel = static_cast<int>(i / 3);
    const int x = std::min(pixel % camera.width / side, columns - 1);
    const int y = std::min(pixel / camera.width / side, rows - 1);
    const double off = std::abs(a[i] - b[i]);
    differences[size_t(y * columns + x)] += off;
  }
  const auto at = static_cast<int>(std::ranges::max_element(differences) - differences.begin());
  // Nothing beside the picture.
  const auto middle = [](int block, double size) {
    return std::clamp((block + 0.5) * side, size / (2.0 * closer), size - size / (2.0 * closer));
  };
  Camera close = camera;
  close.forward =
      camera.direction(middle(at % columns, camera.width), middle(at / columns, camera.height))
          .normalized();
  close.right = close.forward.cross(camera.up).normalized();
  if (close.right.dot(camera.right) < 0.0) close.right = -close.right;
  close.up = close.right.cross(close.forward).normalized();
  if (close.up.dot(camera.up) < 0.0) close.up = -close.up;
  close.fov_degrees = camera.fov_degrees / closer;
  return close;
}

void Lesson::show_leaks() {
  const size_t count = usual_count / 2;
  const Patches cut = mesh(count, true), uncut = mesh(count, false);
  const Exchange right(cut, form_factors(cut, work_), work_);
  const Exchange wrong(uncut, form_factors(uncut, work_), work_);
  const Light right_light = right.light(), wrong_light = wrong.light();
  const Camera close =
      towards_difference(scene_.camera, Film(cut, scene_.camera, work_).flat(right_light),
                         Film(uncut, scene_.camera, work_).flat(wrong_light));
  const std::vector<bool> has_t = cut.has_t_vertex();
  Light marked = right_light;
  for (size_t i = 0; i < marked.size(); ++i) {
    if (has_t[i]) marked[i] = Rgb(0.5, 0.1, 0.1) * std::pow(0.5, exposure_);
  }
  Scene seen = scene_;
  seen.camera = close;
  const Picture exact = draw(seen, {.bounces = {}, .level = 1, .most_bytes = most_bytes_}, work_);
  work_.check();
  const Film right_film(cut, close, work_), wrong_film(uncut, close, work_);
  write_strip("leaks",
              {tile(wrong_film.wire(wrong_light)), tile(right_film.wire(right_light)),
               tile(right_film.wire(marked)), tile(wrong_film.smooth(wrong_light)),
               tile(right_film.smooth(right_light)), tile(exact.rgb)},
              3, exposure_);
  write_numbers("leaks", {{"patches", {uncut.size(), cut.size()}},
                          {"with_t_vertices", std::ranges::count(has_t, true)}});
}

// Points that are seen, with the radiance there by linear elements.
std::vector<Lesson::Sight> Lesson::sights() const {
  constexpr int across = 48;  // the picture
  Elements elements(faces_, most_bytes_ / sizeof(Element));
  auto coarse = std::make_unique<Solution>(elements, Resolution::level(0), BounceRange(), nullptr,
                                           nullptr, most_bytes_, work_);
  elements.refine(coarse->unevenness(), Resolution::level(0).unevenness);
  const Solution solution(elements, Resolution::level(1), {}, nullptr, std::move(coarse),
                          most_bytes_, work_);
  const Camera& camera = scene_.camera;
  const double step = double(camera.width) / across;
  std::vector<Sight> sights;
  Eye eye(faces_);
  for (double y = step / 2.0; y < camera.height; y += step) {
    work_.show(fmt::format("exact radiance, {:.0f} %", 100.0 * y / camera.height));
    work_.check();
    for (double x = step / 2.0; x < camera.width; x += step) {
      const Vec3 direction = camera.direction(x, y);
      const auto hit = patches_.trace(camera.origin, direction);
      if (!hit) continue;
      const size_t face = patches_[hit->patch].face;
      if (!faces_[face].reflects() || faces_[face].is_lamp()) continue;
      eye.move_to(face, hit->point);
      sights.push_back(
          {direction, faces_[face].reflectance * (eye.direct() + solution.gather(eye))});
    }
  }
  return sights;
}

// Of flat and of interpolated patches: the root of the mean of the squared difference, over the
// mean.
std::pair<double, double> Lesson::errors(const Patches& patches, const Light& light,
                                         const std::vector<Sight>& sights) const {
  const Light corners = patches.mean_at_vertices(light);
  double flat = 0.0, smooth = 0.0, sum = 0.0;
  for (const auto& [direction, radiance] : sights) {
    const Hit hit = *patches.trace(scene_.camera.origin, direction);
    const auto weights = patches.weights(hit.patch, hit.point);
    Rgb between(0.0);
    for (size_t k = 0; k < 4; ++k) between += corners[patches.vertex(hit.patch, k)] * weights[k];
    flat += std::pow((light[hit.patch] - radiance).dot(Rgb(1.0)), 2);
    smooth += std::pow((between - radiance).dot(Rgb(1.0)), 2);
    sum += radiance.dot(Rgb(1.0));
  }
  const auto count = static_cast<double>(sights.size());
  return {std::sqrt(flat * count) / sum, std::sqrt(smooth * count) / sum};
}

void Lesson::show_meshes() {
  write_strip("mesh",
              {tile(film_.wire(exact_)), tile(film_.flat(exact_)), tile(film_.smooth(exact_))}, 3,
              exposure_);
  const std::vector<Sight> sights = this->sights();
  std::vector<Tile> wires, pictures;
  ordered_json rows = ordered_json::array();
  for (const size_t count : {125, 250, 500, 1000, 2000}) {
    const Patches patches = mesh(count, true);
    const Exchange exchange(patches, form_factors(patches, work_), work_);
    const Light light = exchange.light();
    const auto [flat, smooth] = errors(patches, light, sights);
    rows.push_back({{"patches", patches.size()}, {"flat", flat}, {"interpolated", smooth}});
    if (count != 125 && count != 500 && count != 2000) continue;
    const Film film(patches, scene_.camera, work_);
    wires.push_back(tile(film.wire(light)));
    pictures.push_back(tile(film.smooth(light)));
  }
  wires.insert(wires.end(), pictures.begin(), pictures.end());
  write_strip("refinement", wires, wires.size() / 2, exposure_);
  write_plot("meshes", rows, "Patches against linear elements", {"patches", "patches"},
             {{"flat", "flat"}, {"interpolated", "interpolated"}});
}

}  // namespace

void teach(const Scene& scene, const std::filesystem::path& folder, double exposure,
           size_t most_bytes, const Work& work) {
  const Faces faces(scene, most_bytes, work);
  if (faces.lamps().empty()) throw std::invalid_argument("there is no lamp in the scene");
  std::error_code failed;  // which the check would tell, too
  std::filesystem::create_directories(folder, failed);
  check_writable(folder / "lesson.json");
  Lesson(scene, faces, folder, exposure, most_bytes, work).give();
}

}  // namespace plumb::cli
