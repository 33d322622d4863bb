// SPDX-License-Identifier: Apache-2.0
#include "cli/option_groups.hpp"

#include <CLI/CLI.hpp>

namespace elastogen {
namespace {

/// Options for facts that an asset file may not state itself.
void add_body_options(CLI::App& app, AnimateOptions& o, Typed& t) {
  app.add_flag("--part-pieces,!--no-part-pieces", o.part_pieces,
               "pieces that do not touch are not joined, however near they are")
      ->group("Scene");
  app.add_option("--thickness", t.thickness,
                 "of sheets and of shells of points, e.g. '2 mm'; auto: that of a voxel")
      ->group("Scene");
  app.add_option("--splat-scales", t.splat_scales, "of splats in a PLY: auto, log or linear")
      ->group("Scene");
  app.add_option("--grid", t.grid, "grid of a .vdb by its name")->group("Scene");
}

/// Options of materials that yield.
void add_yield_options(CLI::App& app, Typed& t) {
  app.add_option("--yield", t.yield,
                 "metal and clay: stress at which a bar flows, e.g. '250 MPa'; snow: pressure p0")
      ->group("Material");
  app.add_option("--hardening", t.hardening,
                 "metal: stress over plastic strain, e.g. '1 GPa'; snow: the factor xi")
      ->group("Material");
  app.add_option("--friction-angle", t.friction_angle, "sand and snow, e.g. '35 deg'")
      ->group("Material");
  app.add_option("--cohesion", t.cohesion,
                 "sand: strain that it bears; snow: tensile strength over p0")
      ->group("Material");
  app.add_option("--keeps-volume", t.keeps_volume,
                 "sand: true or false; true: what opens has to close before it bears again")
      ->group("Material");
}

void add_material_options(CLI::App& app, Typed& t) {
  // law and its numbers
  app.add_option("--material", t.material,
                 "preset: rubber, soft-rubber, jelly, foam, steel, clay, snow, ...")
      ->group("Material");
  app.add_option("--law", t.law,
                 "fixed-corotated, neo-hookean, stable-neo-hookean, stvk, hencky, ogden=EXPONENT, "
                 "mooney-rivlin=SHARE or gent=LIMIT")
      ->group("Material");
  app.add_option("--young", t.young, "Young's modulus, e.g. 1e6 or '1 MPa'")->group("Material");
  app.add_option("--poisson", t.poisson, "Poisson's ratio, 0 <= nu < 0.5")->group("Material");
  app.add_option("--density", t.density, "density, e.g. 1100 or '1.1 g/cm3'")->group("Material");
  app.add_option(
         "--damping", t.damping,
         "loss factor tan(delta), 0 for none; auto: that of the preset, and none with euler "
         "and bdf2, which damp by themselves")
      ->group("Material");
  app.add_option("--damping-frequency", t.damping_frequency,
                 "at which the loss factor holds, e.g. '10 Hz'; it is in proportion to frequency")
      ->group("Material");
  add_yield_options(app, t);
  // other materials in parts of the body
  app.add_option("--region", t.regions,
                 "part of another material: 'y>80%: foam,young=1e5'; repeatable")
      ->group("Material")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

/// Options for parts that are held, and for obstacles.
void add_constraint_options(CLI::App& app, Typed& t) {
  const auto add_texts = [&](const char* name, std::vector<std::string>& texts, const char* text) {
    app.add_option(name, texts, text)
        ->group("Scene")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  };
  // what is held, what is in the way, what is loaded and moved
  add_texts("--pin", t.pins,
            "hold a part: y<5%, z>0.2m, box(x,y,z,x,y,z), sphere(x,y,z,r), all, or what the asset "
            "names or paints: node:NAME, material:NAME, colour:#RRGGBB, attr:NAME>0.5; repeatable");
  add_texts("--collider", t.colliders,
            "plane(x,y,z, nx,ny,nz), sphere(x,y,z, r) or box(x0,y0,z0, x1,y1,z1), then "
            "friction F (or sticky), name NAME, path T:x,y,z; T:x,y,z; repeatable");
  add_texts("--hold", t.holds,
            "hold a part along some axes only: 'x<1%: x', 'all: yz'; repeatable");
  add_texts("--traction", t.tractions,
            "a force [N] spread over a part of the surface: 'x>99%: 0,-10,0', or a "
            "pressure [Pa] on it: 'x>99%: 2e3'; repeatable");
  add_texts("--force", t.forces,
            "a force [N] on a part, spread by mass: 'y>80%: 10,0,0', or in time 'y>80%: "
            "T:x,y,z; T:x,y,z'; repeatable");
  add_texts("--move", t.moves,
            "move a part: 'x>99%: shift T:x,y,z; T:x,y,z' or 'x>99%: turn(x,y,z, ax,ay,az) "
            "T:ANGLE; T:ANGLE' about a point and an axis; 'ease' before the keys slows down at "
            "each, 'loop' begins anew; repeatable");
}

void add_scene_options(CLI::App& app, AnimateOptions& o, Typed& t) {
  add_constraint_options(app, t);
  // forces and motion at the start
  app.add_option("--wind", t.wind,
                 "velocity of the air x,y,z [m/s], or in time T:x,y,z; T:x,y,z; it presses on the "
                 "surface")
      ->group("Scene");
  app.add_option("--gravity", t.gravity, "x,y,z [m/s^2]; default 9.81 down")->group("Scene");
  app.add_option("--velocity", t.velocity, "start velocity x,y,z [m/s]")->group("Scene");
  app.add_option("--spin", t.spin, "start spin x,y,z [rad/s] about the centre of mass")
      ->group("Scene");
  // floor and contact
  app.add_option("--floor", t.floor,
                 "floor plane AXIS=PLACE; alone: the asset's lowest point; off: none")
      ->group("Scene")
      ->expected(0, 1);
  app.add_option("--friction", t.friction,
                 "Coulomb's coefficient with floor and colliders; sticky: particles that touch "
                 "them move with them")
      ->group("Scene")
      ->capture_default_str();
  // resolution and size
  app.add_option("--voxels", o.voxels, "voxels along the longest edge")
      ->group("Scene")
      ->capture_default_str();
  app.add_option("--h", t.h, "voxel edge, e.g. '5 mm', instead of --voxels")->group("Scene");
  app.add_option("--size", t.size, "longest edge of the asset, e.g. '30 cm'")->group("Scene");
  add_body_options(app, o, t);
  app.add_option(
         "--shape", t.shape,
         "body in place of INPUT: box(x0,y0,z0, x1,y1,z1), sphere(x,y,z, r), or in the plane "
         "rectangle(x0,y0,0, x1,y1,0), disk(x,y,0, r)")
      ->group("Scene");
  app.add_option("--up", t.up, "direction that points up: auto, x, y, z, -x, -y or -z")
      ->group("Scene")
      ->capture_default_str();
}

/// Length and rate of the clip, and its time steps.
void add_time_options(CLI::App& app, AnimateOptions& o, Typed& t) {
  app.add_option("--frames", o.frames, "frames after the first")->capture_default_str();
  app.add_option("--fps", o.fps, "frames a second")->capture_default_str();
  app.add_option("--substeps", t.substeps, "time steps a frame, or auto")->capture_default_str();
  app.add_option("--time-scheme", t.scheme,
                 "auto: steps by their time error; sdirk2, bdf2, euler: steps of one length. Left "
                 "out: auto, with --substeps sdirk2; euler for particles, materials that yield and "
                 "the solver paper");
  app.add_option("--time-error", t.time_error,
                 "time scheme auto: share of a frame's motion that its steps may be off, e.g. 0.2%")
      ->capture_default_str();
}

/// Hardware, budgets, what is an error and what is printed.
void add_machine_options(CLI::App& app, AnimateOptions& o, Typed& t) {
  app.add_option("--device", t.device, "auto, cpu or cuda")->capture_default_str();
  app.add_flag_callback(
      "--deterministic", [] {}, "the same bits on every run; always so, sums have a fixed order");
  app.add_option("--threads", o.threads, "0: all")->capture_default_str();
  app.add_option("--max-memory", t.max_memory, "budget, e.g. '8 GB'");
  app.add_option("--max-voxels", o.max_voxels, "budget")->capture_default_str();
  app.add_option("--max-time", t.max_time, "wall time of the steps, e.g. '10 min'");
  app.add_flag("--no-skip,!--skip", t.no_skip, "take no shortcut that the scene would allow");
  app.add_flag("--strict,!--no-strict", o.strict, "warnings are errors");
  app.add_flag("--strict-time,!--no-strict-time", o.strict_time,
               "exit code 4 for frames above the time error");
  app.add_flag("--quiet,!--no-quiet", o.quiet, "print errors only");
}

void add_run_options(CLI::App& app, AnimateOptions& o, Typed& t) {
  // time, solver, energy, then the rest
  add_time_options(app, o, t);
  app.add_option("--solver", t.solver, "auto, quasi, newton or paper")->capture_default_str();
  app.add_option("--tolerance", o.solver.tolerance, "of the residual |grad E|/|M g|")
      ->capture_default_str();
  app.add_option("--outer", o.solver.paper.outer, "solver paper: outer loops a step")
      ->capture_default_str();
  app.add_option("--inner", o.solver.paper.inner, "solver paper: sweeps of each loop")
      ->capture_default_str();
  app.add_option("--modes", o.solver.paper.modes,
                 "solver paper: latent size, three times the cosines")
      ->capture_default_str();
  app.add_option("--hourglass", t.hourglass,
                 "full, variance, off, or auto: variance for the paper solver, else full")
      ->capture_default_str();
  app.add_option("--energy", t.energy,
                 "auto: by the nets of the materials, by the law where none keeps its limits; "
                 "neural: by nets or not at all; analytic: by the laws")
      ->capture_default_str();
  app.add_flag_callback(
      "--analytic", [&t] { t.energy = "analytic"; }, "the same as --energy analytic");
  app.add_option("--method", t.method,
                 "of what yields: mpm, fem, or auto: mpm where it falls apart into grains")
      ->capture_default_str();
  app.add_option("--mesh-error", t.mesh_error,
                 "on or off: estimate by how much frames are wrong because of the voxels' size")
      ->capture_default_str();
  add_machine_options(app, o, t);
}

void add_particle_options(CLI::App& app, AnimateOptions& o, Typed& t) {
  ParticleOptions& p = o.particles;
  const auto add = [&](const char* name, auto& value, const char* text) {
    app.add_option(name, value, text)->group("Particles")->capture_default_str();
  };
  add("--integrator", t.integrator, "implicit, explicit, frozen-fixed-point or pn-fixed-point");
  add("--dt", t.dt, "from transfer to transfer, e.g. '1 ms'; auto: by speed, or that of waves");
  add("--particle-substeps", p.substeps, "explicit: steps from transfer to transfer");
  add("--passes", p.passes, "pn-fixed-point: minima of a step");
  add("--per-edge", p.per_edge, "particles of a full voxel along an axis");
  add("--jitter", p.jitter, "share of its part of the voxel where a particle stands at random");
  add("--transfer", t.transfer, "apic, apic-blend, rpic or flip");
  add("--blend-time", t.blend_time, "apic-blend: time in which the grid smooths velocities");
  add("--flip", p.transfer.flip, "flip: share of the particles' own velocity");
}

void add_output_options(CLI::App& app, AnimateOptions& o, Typed& t) {
  // animations
  app.add_option(
         "-o,--output", o.outputs,
         "animation to write: .glb, .ply (a file a frame), .pc2, .pvd, of particles also .obj, "
         ".mesh.ply and .vdb (a file a frame), .png (a sheet of pictures, with %04d in its "
         "name a picture a frame); repeatable")
      ->group("Output")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--glb-profile", t.profile, "modal or keyframe")
      ->group("Output")
      ->capture_default_str();
  app.add_option("--glb-targets", o.glb_targets,
                 "most morph targets of a mesh; longer clips are shown in pieces")
      ->group("Output")
      ->capture_default_str();
  app.add_flag("--glb-colliders,!--no-glb-colliders", o.glb_colliders,
               "floor and colliders in the GLB too")
      ->group("Output");
  // pictures
  app.add_option("--camera", t.camera,
                 "pictures from three-quarter, front, back, left, right, top, or turntable: once "
                 "around")
      ->group("Output")
      ->capture_default_str();
  app.add_option("--image-size", t.image_size,
                 "pixels of a picture, WIDTHxHEIGHT; auto: 320x320 on a sheet, else 960x540")
      ->group("Output")
      ->capture_default_str();
  // files about the run
  app.add_option("--state", o.state, "state file (HDF5)")->group("Output");
  app.add_option("--log-json", o.log, "one JSON object a time step")->group("Output");
  app.add_option("--report", o.report, "summary of the run (JSON)")->group("Output");
}

}  // namespace

void add_scene_groups(CLI::App& app, AnimateOptions& options, Typed& typed) {
  add_output_options(app, options, typed);
  add_material_options(app, typed);
  add_scene_options(app, options, typed);
  add_run_options(app, options, typed);
  add_particle_options(app, options, typed);
}

void add_resolution_options(CLI::App& app, AnimateOptions& o, Typed& t) {
  app.add_option("--voxels", o.voxels, "voxels along the longest edge")->capture_default_str();
  app.add_option("--h", t.h, "voxel edge, e.g. '5 mm', instead of --voxels");
  app.add_option("--size", t.size, "longest edge of the asset, e.g. '30 cm'");
  add_body_options(app, o, t);
  app.add_option("--max-memory", t.max_memory, "budget, e.g. '8 GB'");
  app.add_option("--max-voxels", o.max_voxels, "budget")->capture_default_str();
  app.add_option("--threads", o.threads, "0: all")->capture_default_str();
}

}  // namespace elastogen
