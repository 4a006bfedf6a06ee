// voxatlas: the command line.
//
//   publish    scans from files or the simulated drive, reliably, to ingests
//   render     a picture of the model as a file
//   watch      frames | tiles | status, as they are published
//   stat       what the model holds
//   simulate   the simulated drive as files
//   doctor     what is wrong with the bus, the services, the machine, and how to mend it
//   store      a model at rest: verify | stat | checkpoint | copy | compact | reshard | merge
//
// Every subcommand is a file of its own; this one declares their options.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <functional>

#include "base/log.hpp"
#include "bus/bus_url.hpp"
#include "bus/lcm_log.hpp"
#include "bus/service_loop.hpp"
#include "cli/doctor.hpp"
#include "cli/publish.hpp"
#include "cli/render.hpp"
#include "cli/simulate.hpp"
#include "cli/stat.hpp"
#include "cli/store.hpp"
#include "cli/watch.hpp"

namespace voxatlas {

/// What the chosen subcommand will do.
using Command = std::function<Status()>;

static void declare_publish(CLI::App& app, Command& command);
static void declare_render(CLI::App& app, Command& command);
static void declare_watch(CLI::App& app, Command& command);
static void declare_stat(CLI::App& app, Command& command);
static void declare_simulate(CLI::App& app, Command& command);
static void declare_doctor(CLI::App& app, Command& command);
static void declare_store(CLI::App& app, Command& command);

}  // namespace voxatlas

int main(int argc, char** argv) {
  voxatlas::Command command;
  CLI::App app{
      "voxatlas: a probabilistic voxel model of the whole Earth.\n"
      "Start the services with scripts/up, then publish scans and ask for pictures."};
  app.require_subcommand(1);
  voxatlas::declare_publish(app, command);
  voxatlas::declare_render(app, command);
  voxatlas::declare_watch(app, command);
  voxatlas::declare_stat(app, command);
  voxatlas::declare_simulate(app, command);
  voxatlas::declare_doctor(app, command);
  voxatlas::declare_store(app, command);
  CLI11_PARSE(app, argc, argv);
  voxatlas::stop_on_signals();
  try {
    const auto done = command();
    if (done) return 0;
    fmt::print(stderr, "voxatlas: {}\n", done.error().message);
  } catch (const std::exception& e) {  // Nothing can go on: no memory, no threads.
    fmt::print(stderr, "voxatlas: {}\n", e.what());
  }
  return 1;
}

namespace voxatlas {

static void add_url(CLI::App& app, std::string& url) {
  url = kDefaultBusUrl;
  app.add_option("--url", url, "LCM URL of the bus")
      ->envname("LCM_DEFAULT_URL")
      ->capture_default_str();
}

/// A subcommand whose options live as long as the program, and what it runs.
template <class Options>
static Options& add_command(CLI::App& app, CLI::App*& sub, const char* name, const char* help,
                            Command& command, Status (*run)(const Options&)) {
  auto options = std::make_shared<Options>();  // Owned by the callback, as long as the app lives.
  sub = app.add_subcommand(name, help);
  sub->callback([options, run, &command] { command = [options, run] { return run(*options); }; });
  return *options;
}

static void add_drive(CLI::App& app, SimulatedInput& drive) {
  app.add_option("--seed", drive.seed, "of the simulated city and drive")->capture_default_str();
  app.add_option("--place", drive.place, "LAT,LON,HEIGHT of the simulated city's middle [Munich]");
  app.add_option("--speed", drive.speed, "of the simulated car, metres a second")
      ->capture_default_str();
  app.add_option("--azimuth-step", drive.azimuth_step_deg,
                 "degrees the simulated scanners turn from beam to beam")
      ->capture_default_str();
}

static void declare_publish(CLI::App& app, Command& command) {
  CLI::App* sub = nullptr;
  auto& options = add_command<PublishOptions>(app, sub, "publish",
                                              "publish scans reliably; returns when every one is "
                                              "durable, and run again goes on where it was",
                                              command, run_publish);
  add_url(*sub, options.url);
  auto* folder = sub->add_option("input", options.kitti.folder,
                                 "scans in KITTI odometry form: a folder with velodyne/NNNNNN.bin "
                                 "and times.txt; or a log of lcm-logger, which holds "
                                 "voxatlas.scan_t, or bot_core.pointcloud_t and pose_t");
  auto* poses =
      sub->add_option("--poses", options.kitti.poses,
                      "12 numbers a line, ecef_from_sensor; looked up in the folder first");
  sub->add_option(
      "--origin", options.kitti.origin,
      "LAT,LON,HEIGHT of the poses' local frame (east, north, up), where they have one");
  sub->add_option("--cloud-channel", options.log.cloud_channel,
                  "of a log: take the clouds of this channel alone");
  sub->add_option("--pose-channel", options.log.pose_channel,
                  "of a log: the channel of the clouds' poses, where there are several");
  auto* simulate = sub->add_option("--simulate", options.simulate.scans,
                                   "publish so many scans of the simulated drive instead");
  add_drive(*sub, options.simulate);
  sub->add_option("--source", options.source, "who publishes [the input's name]");
  sub->add_option("--session", options.session,
                  "number of the run [made of the input: the same input is never added twice]")
      ->check(CLI::NonNegativeNumber);
  sub->add_option("--sigma", options.sigma,
                  "standard deviation of the points, localisation included, metres [0.02]");
  sub->add_option("--min-range", options.min_range,
                  "nearer returns are the vehicle, metres [2.5; simulated: 0]");
  sub->add_option("--hz", options.hz, "at most so many scans a second, as a sensor would send them")
      ->check(CLI::PositiveNumber);
  sub->add_option("--ingests", options.ingests, "how many ingests to spread over")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  sub->add_flag("--json", options.json, "print the result as JSON");
  folder->excludes(simulate);
  poses->needs(folder);
  sub->parse_complete_callback([sub, &options] {
    if (sub->count("input") + sub->count("--simulate") == 0) {
      throw CLI::RequiredError("a folder with --poses, a log, or --simulate N,");
    }
    if (sub->count("input") > 0 && !is_lcm_log(options.kitti.folder)) {
      if (sub->count("--poses") == 0) throw CLI::RequiredError("--poses, for a folder of scans,");
    }
  });
}

static void declare_render(CLI::App& app, Command& command) {
  CLI::App* sub = nullptr;
  auto& options = add_command<RenderOptions>(
      app, sub, "render", "a picture of the model, or those along a path", command, run_render);
  add_url(*sub, options.url);
  sub->add_option("--view", options.view, "a view of what the model holds")
      ->check(CLI::IsMember({"street", "oblique"}))
      ->capture_default_str();
  auto* at =
      sub->add_option("--at", options.at, "stand at LAT,LON,HEIGHT instead (above the ellipsoid)");
  auto* heading = sub->add_option("--heading", options.heading,
                                  "and look this way, degrees from north, east is 90")
                      ->needs(at);
  sub->add_option("--look-at", options.look_at,
                  "or at this place, LAT,LON,HEIGHT; of an orbit: its middle")
      ->excludes(heading);
  sub->add_option("--map", options.map,
                  "orthographic instead, straight down, north up: so many metres from left to "
                  "right, around --at or the model's middle")
      ->check(CLI::Range(1.0, 2000.0));
  auto* orbit =
      sub->add_option("--orbit", options.orbit, "so many pictures, once round what the model holds")
          ->check(CLI::Range(1, 900));
  auto* path =
      sub->add_option("--path", options.path,
                      "file of a camera path: lines SECONDS LAT,LON,HEIGHT LAT,LON,HEIGHT, "
                      "eye and what it looks at")
          ->excludes(orbit)
          ->excludes(at);
  sub->add_option("--rate", options.rate, "pictures a second of the path")
      ->check(CLI::Range(0.001, 1000.0))
      ->needs(path)
      ->capture_default_str();
  sub->add_option("--fov", options.fov, "of --look-at and --path, degrees from top to bottom [60]")
      ->check(CLI::Range(1.0, 170.0));
  sub->add_option("--size", options.size, "WIDTHxHEIGHT, pixels")->capture_default_str();
  sub->add_option("--depth", options.depth, "depth of the cells drawn: 0 to 7 (10 cm)")
      ->check(CLI::Range(0, 7))
      ->capture_default_str();
  sub->add_option("--budget", options.budget,
                  "milliseconds for a first picture, which better ones follow [0: the full one]")
      ->check(CLI::Range(0.0, 3'600'000.0));
  sub->add_option("--colouring", options.colouring,
                  "rgb, height, probability ... (an error lists all)")
      ->capture_default_str();
  sub->add_option("--backend", options.backend, "splat, or gl: OpenGL's points, to compare with")
      ->check(CLI::IsMember({"splat", "gl"}))
      ->capture_default_str();
  sub->add_flag("--fill-holes", options.fill_holes, "close gaps between far cells");
  sub->add_option("--free-depth", options.free_depth,
                  "free cells of this depth as translucent grey, 1 to 7 [0: none]")
      ->check(CLI::Range(0, 7));
  sub->add_flag("--boxes", options.boxes, "draw the edges of tiles on top");
  sub->add_flag("--axes", options.axes, "draw the axes of ECEF on top");
  sub->add_flag("--north", options.north, "draw which way is north on top");
  sub->add_flag("--scale", options.scale, "draw a bar of a round length on top");
  sub->add_option("--out", options.out,
                  "file to be written: .jpg, .raw (RGB), else PNG; a JPEG with --broadcast. Of a "
                  "path or orbit the folder: frame_000000.png ...")
      ->required();
  sub->add_option("--depth-image", options.depth_image,
                  "file for distances: float32 metres row by row, or steps of uint16 in a .u16");
  sub->add_flag("--broadcast", options.broadcast,
                "let everyone who watches frames see it too, as a JPEG of at most 150 kB");
  sub->add_option("--timeout", options.timeout, "seconds to wait for the picture")
      ->capture_default_str();
  sub->add_flag("--json", options.json, "print what was drawn and the stages' times as JSON");
}

static void declare_watch_tiles(CLI::App& tiles, WatchOptions& options) {
  auto* box = tiles.add_option("--box", options.box,
                               "X,Y,Z,X,Y,Z: only tiles that touch the box with these opposite "
                               "corners, ECEF, metres");
  auto* around =
      tiles.add_option("--around", options.around, "LAT,LON,HEIGHT: only tiles near this place");
  around->excludes(box);
  tiles.add_option("--radius", options.radius, "how near, metres, on each axis")
      ->check(CLI::PositiveNumber)
      ->needs(around)
      ->capture_default_str();
  auto* follow = tiles.add_flag("--follow", options.follow,
                                "keep a copy of the tiles, from a snapshot and all updates, and "
                                "say each time it is in step with the stores");
  tiles.add_option("--depth", options.depth, "of that copy: 0 to 7 (10 cm)")
      ->check(CLI::Range(0, 7))
      ->needs(follow)
      ->capture_default_str();
  tiles
      .add_option("--hashes", options.hashes,
                  "write the copy's keys, versions and SHA-256 to this file each time it is in "
                  "step, as stat --hashes does")
      ->needs(follow);
  tiles
      .add_option("--quiet", options.quiet,
                  "end when it is in step and nothing has come for so many seconds [0: never]")
      ->needs(follow);
}

static void declare_watch(CLI::App& app, Command& command) {
  auto* watch = app.add_subcommand("watch", "print what is published, a line each, until Ctrl-C");
  watch->require_subcommand(1);
  const auto add = [&](const char* name, const char* help, Status (*run)(const WatchOptions&)) {
    CLI::App* sub = nullptr;
    auto& options = add_command<WatchOptions>(*watch, sub, name, help, command, run);
    add_url(*sub, options.url);
    sub->add_option("--count", options.count, "end after so many messages [0: never]");
    sub->add_option("--timeout", options.timeout, "seconds, then it is an error [0: none]");
    sub->add_flag("--json", options.json, "one JSON object a line");
    return std::pair<CLI::App*, WatchOptions*>(sub, &options);
  };
  auto [frames, frame_options] = add("frames", "pictures that renderers broadcast", watch_frames);
  frames->add_option("--out", frame_options->out, "folder to keep the pictures in");
  frames->add_flag("--blocks", frame_options->blocks,
                   "show them in the terminal, in half-block characters of 24-bit colours");
  auto [tiles, tile_options] = add("tiles", "tiles that have changed", watch_tiles);
  declare_watch_tiles(*tiles, *tile_options);
  auto [status, status_options] =
      add("status", "how each service is, twice a second", watch_status);
  status->add_option("--only", status_options->only, "of one service, such as \"render 0\" [all]");
  status->add_option("--until-ready", status_options->until_ready,
                     "end when so many services are ready [0: never]");
}

static void declare_stat(CLI::App& app, Command& command) {
  CLI::App* sub = nullptr;
  auto& options = add_command<StatOptions>(
      app, sub, "stat", "what the model holds: tiles, cells by state, bytes", command, run_stat);
  add_url(*sub, options.url);
  sub->add_option("--hashes", options.hashes,
                  "write key, version and SHA-256 of every tile to this file");
  sub->add_flag("--json", options.json, "print as JSON");
}

static void declare_simulate(CLI::App& app, Command& command) {
  CLI::App* sub = nullptr;
  auto& options = add_command<SimulateOptions>(
      app, sub, "simulate", "write the simulated drive as files that publish reads", command,
      run_simulate);
  sub->add_option("scans", options.drive.scans, "how many")->required()->check(CLI::PositiveNumber);
  sub->add_option("--out", options.out, "folder to be made")->required();
  add_drive(*sub, options.drive);
}

static void declare_doctor(CLI::App& app, Command& command) {
  CLI::App* sub = nullptr;
  auto& options = add_command<DoctorOptions>(
      app, sub, "doctor",
      "look at bus, services, data folder, disk and clock; say what is wrong and what mends it",
      command, run_doctor);
  add_url(*sub, options.url);
  sub->add_option("--data-dir", options.data_dir, "folder of the set")->capture_default_str();
  sub->add_option("--listen", options.listen, "seconds to hear the services")
      ->check(CLI::Range(0.1, 60.0))
      ->capture_default_str();
  sub->add_flag("--json", options.json, "one JSON object a finding");
}

static void declare_store(CLI::App& app, Command& command) {
  auto* store = app.add_subcommand("store", "a model's folder");
  store->require_subcommand(1);
  const auto add = [&](const char* name, const char* help, Status (*run)(const StoreOptions&)) {
    CLI::App* sub = nullptr;
    auto& options = add_command<StoreOptions>(*store, sub, name, help, command, run);
    sub->add_option("--data-dir,--store", options.data_dir,
                    "folder of the model, or rados:CONF,POOL[,MODEL] for one in a Ceph cluster")
        ->required();
    return std::pair<CLI::App*, StoreOptions*>(sub, &options);
  };
  auto [verify, verify_options] =
      add("verify", "read everything, check everything, change nothing; also while it runs",
          run_store_verify);
  add_url(*verify, verify_options->url);
  verify->add_flag("--json", verify_options->json, "one JSON object a shard");
  auto [stat, stat_options] =
      add("stat", "tiles, bytes, journal, marks of each shard; also while it runs", run_store_stat);
  add_url(*stat, stat_options->url);
  stat->add_flag("--json", stat_options->json, "one JSON object a shard");
  stat->add_option("--hashes", stat_options->hashes,
                   "write key, version and SHA-256 of every tile to this file");
  stat->add_option("--marks", stat_options->marks,
                   "write how far each source's scans are applied to this file, a line for each "
                   "shard and source: shard, seq, session, source");
  auto [checkpoint, checkpoint_options] =
      add("checkpoint", "a consistent copy that is a model of its own; also while it runs",
          run_store_checkpoint);
  add_url(*checkpoint, checkpoint_options->url);
  checkpoint->add_option("to", checkpoint_options->target, "folder to be made")->required();
  CLI::App* copy = nullptr;
  auto& copy_options = add_command<StoreOptions>(
      *store, copy, "copy",
      "a copy from a folder or a cluster to either, compared by SHA-256; run again after an "
      "interruption it goes on",
      command, run_store_copy);
  copy->add_option("from", copy_options.data_dir,
                   "the model, at rest: a folder, or rados:CONF,POOL[,MODEL]")
      ->required();
  copy->add_option("to", copy_options.target, "where to, likewise")->required();
  add("compact", "rewrite the files without what was overwritten", run_store_compact);
  auto [reshard, reshard_options] =
      add("reshard", "the same model in another number of shards", run_store_reshard);
  reshard->add_option("shards", reshard_options->shards, "how many")
      ->required()
      ->check(CLI::Range(1, 100));
  auto [merge, merge_options] =
      add("merge", "add another model's log-odds, tile by tile", run_store_merge);
  merge->add_option("other", merge_options->target, "folder of the other model, also at rest")
      ->required();
}

}  // namespace voxatlas
