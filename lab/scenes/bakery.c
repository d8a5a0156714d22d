// SPDX-License-Identifier: MIT
//
// A hall with five equal doughnut lines: dough is mixed, funnelled, sheeted, cut, proofed on
// swings, baked on a wire-mesh belt, glazed, cooled on a spiral, and packed. A line is one
// prototype, used five times.
#include "lab/scenes/paper.h"
#include "lab/scenes/parts.h"
#include "lab/scenes/scene_random.h"

enum {
    LINES = 5,
    LINE_OBJECTS = 1400,
    LINE_MESHES = 480,
    HALL_OBJECTS = 237, // 7,237 = 5 x 1,400 + 237
    HALL_MESHES = 31,
};

const plan_counts bakery_counts = {7237, 511, 267800000, 27700000};

#define PART(name, finish, maker, place, ...)                                                      \
    plan_part(plan, group, name, finish, maker, PARAMETERS(__VA_ARGS__), place)
#define MESH(name, finish, maker, ...)                                                             \
    plan_add_mesh(plan, name, finish, maker, PARAMETERS(__VA_ARGS__))

// Parts that a line has many of: one mesh each.
typedef struct standard_parts {
    uint32_t tray, dough, glaze, roller, belt, chain, motor, gearbox, guard, oven_shell,
        oven_nozzles, oven_burner, mesh_belt, swings, rack, post;
} standard_parts;

static standard_parts add_standard_parts(assembly_plan* plan)
{
    return (standard_parts){
        .tray = MESH("tray", FINISH_ALUMINIUM, part_tray, 4, 6, 0.12),
        .dough = MESH("doughnuts on a tray", FINISH_DOUGH, part_donuts, 4, 6, 0.045, 0.12, 0),
        .glaze = MESH("glaze on a tray", FINISH_GLAZE, part_donuts, 4, 6, 0.043, 0.12, 1),
        .roller = MESH("roller conveyor 2 m", FINISH_STAINLESS, part_roller_conveyor, 2, 0.8, 0.95,
                       0.075),
        .belt = MESH("belt conveyor 3 m", FINISH_PAINT_BLUE, part_belt_conveyor, 3, 0.7, 0.95),
        .chain = MESH("drive chain", FINISH_STEEL, part_chain, 1.4, 0.019, 2, 0.06),
        .motor = MESH("gear motor", FINISH_PAINT_BLUE, part_motors, 1, 0.09, 1),
        .gearbox = MESH("gear box", FINISH_CAST_IRON, part_gearbox, 0.4, 0.3, 0.25),
        .guard = MESH("guard door", FINISH_PAINT_YELLOW, part_guards, 1, 1.5),
        .oven_shell = MESH("oven section shell", FINISH_STAINLESS, part_oven_shell, 2, 1.9, 1.6),
        .oven_nozzles = MESH("oven section nozzles", FINISH_STAINLESS, part_oven_nozzles, 1.9, 1.5,
                             1.05, 60, 46),
        .oven_burner =
            MESH("oven section burners", FINISH_PAINT_RED, part_oven_burner, 1.9, 3, 1.95),
        .mesh_belt = MESH("oven belt 2 m", FINISH_STEEL, part_mesh_belt, 2, 1.3, 1.05, 0.014),
        .swings = MESH("proofer swings", FINISH_PLASTIC_WHITE, part_swings, 8, 6, 1.3, 0.34),
        .rack = MESH("tray rack", FINISH_STAINLESS, part_tray_rack, 18, 0.8, 0.7, 1.9),
        .post =
            MESH("machine foot", FINISH_STAINLESS, part_box_rows, 0.2, 0.2, 2, 2, 0.06, 0.9, 0.06),
    };
}

static void plan_mixing(assembly_plan* plan, uint32_t line)
{
    uint32_t group = plan_group(plan, line, "station 1: mixing", place_at(-46, 0, 0));
    for (int i = 0; i < 4; ++i) {
        double x = -5 + 3.4 * i;
        uint32_t module =
            plan_group(plan, group, plan_text(plan, "mixer %d", i + 1), place_at(x, 0, -1.6));
        plan_part(plan, module, "machine", FINISH_PAINT_WHITE, part_mixer, PARAMETERS(0.6, 1.7),
                  place_at(0, 0, 0));
        plan_part(plan, module, "bowl", FINISH_STAINLESS, part_mixer_bowl, PARAMETERS(0.62, 0.75),
                  place_at(0, 0.28, 0));
        plan_part(plan, module, "cabinet", FINISH_PAINT_LIGHT_GREY, part_cabinets, PARAMETERS(2, 2),
                  place_by_turn(0, 0, -2.0, 0));
        plan_part(plan, module, "cabinet wiring", FINISH_COPPER, part_cabinet_wires,
                  PARAMETERS(2, 2), place_by_turn(0, 0, -2.0, 0));
        plan_part(plan, group, plan_text(plan, "flour silo %d", i + 1), FINISH_ALUMINIUM, part_tank,
                  PARAMETERS(1.1, 4.5, 8), place_at(x, 0, 2.4));
        plan_part(plan, group, plan_text(plan, "dosing hopper %d", i + 1), FINISH_STAINLESS,
                  part_hoppers, PARAMETERS(1, 1, 1.0, 0.8, 2.3), place_at(x, 0, -1.6));
        plan_part(plan, group, plan_text(plan, "flour pipe %d", i + 1), FINISH_STAINLESS,
                  part_pipe_run, PARAMETERS(0.05, 2.5, 0.6, -2, 4.6, 1, 1), place_at(x, 0, 2.4));
    }
    PART("platform", FINISH_GALVANISED, part_floor, place_at(0, 2.2, 0), 12, 2, 0, 0);
    PART("platform frame", FINISH_STAINLESS, part_frame, place_at(0, 0, 0), 12, 2.2, 2, 4, 1, 1,
         0.12);
    PART("platform railings", FINISH_STAINLESS, part_railings, place_at(0, 2.2, 0), 12, 2);
    PART("stairs", FINISH_STAINLESS, part_stairs, place_at(7.4, 0, 0), 2.2, 1);
    PART("water pumps", FINISH_STAINLESS, part_pump_skid, place_at(2, 0, 4.0), 3, 3, 0.06);
    PART("water valves", FINISH_STAINLESS, part_valve_station, place_at(-3, 0, 4.0), 3, 5, 0.03);
}

static void plan_make_up(assembly_plan* plan, uint32_t line, const standard_parts* parts)
{
    uint32_t group = plan_group(plan, line, "station 2: make-up", place_at(-30, 0, 0));
    PART("dough funnel", FINISH_STAINLESS, part_funnel, place_at(-5, 0.2, 0), 1.2, 1.1, 0.4);
    PART("dough lift", FINISH_STAINLESS, part_lattice_mast, place_at(-6.5, 0, 0.2), 3.6, 0.4, 10,
         0);
    PART("lift chain", FINISH_STEEL, part_chain,
         ((stp_affine){{{0, -1, 0, -6.1}, {1, 0, 0, 1.8}, {0, 0, 1, 0}}}), 3.2, 0.04, 2, 0.12);
    for (int i = 0; i < 4; ++i) {
        double x = -3.5 + 2.4 * i;
        uint32_t module =
            plan_group(plan, group, plan_text(plan, "sheeter %d", i + 1), place_at(x, 0, 0));
        plan_part(plan, module, "rollers", FINISH_STAINLESS, part_sheeter,
                  PARAMETERS(0.9, 6 + i, 0.09), stp_affine_identity());
        plan_part(plan, module, "flour duster", FINISH_STAINLESS, part_funnel,
                  PARAMETERS(0.7, 0.4, 0.3), place_at(0.5, 0.5, 0));
        plan_part(plan, module, "drive chain", FINISH_STEEL, part_chain,
                  PARAMETERS(1.2, 0.025, 2, 0.09), place_at(0, 0.5, 0));
        plan_part(plan, module, "guards", FINISH_PAINT_YELLOW, part_guards, PARAMETERS(2, 0.9),
                  place_at(0, 0.6, -0.8));
        plan_part(plan, module, "cables", FINISH_PLASTIC_BLACK, part_cable_tray,
                  PARAMETERS(2.3, 0.2, 24, 1, 0.35), place_at(0, 0, 0.3));
    }
    for (int i = 0; i < 3; ++i) {
        PART(plan_text(plan, "cutter %d", i + 1), FINISH_STAINLESS, part_cutter,
             place_at(5.2 + 0.8 * i, 0, 0), 0.9, 18 + 4 * i);
        PART(plan_text(plan, "retractor belt %d", i + 1), FINISH_RUBBER, part_belt_conveyor,
             place_at(5.4 + 1.0 * i, 0, 0), 0.9, 0.8, 1.0);
    }
    for (int i = 0; i < 6; ++i) {
        plan_place(plan, group, plan_text(plan, "belt %d", i + 1), parts->belt,
                   place_at(-5 + 3.0 * i, 0, 0));
    }
}

static void plan_proofer(assembly_plan* plan, uint32_t line, const standard_parts* parts)
{
    uint32_t group = plan_group(plan, line, "station 3: proofing", place_at(-14, 0, 0));
    for (int i = 0; i < 4; ++i) {
        uint32_t module = plan_group(plan, group, plan_text(plan, "proofer bay %d", i + 1),
                                     place_at(-4.7 + 3.1 * i, 0, 0));
        plan_part(plan, module, "frame and chains", FINISH_STAINLESS, part_proofer_frame,
                  PARAMETERS(3, 1.7, 3.6), stp_affine_identity());
        plan_place(plan, module, "swings", parts->swings, place_at(0, 0, 0));
        plan_part(plan, module, "swings of the return", FINISH_PLASTIC_WHITE, part_swings,
                  PARAMETERS(7, 6, 1.25, 0.36), place_at(0.05, 0.25, 0));
        plan_part(plan, module, "panel", FINISH_PAINT_WHITE, part_cladding,
                  PARAMETERS(3, 3.4, 0.1, 0.01), place_by_turn(0, 0.1, -0.95, 0.5));
        plan_part(plan, module, "humidifier", FINISH_STAINLESS, part_heat_exchanger,
                  PARAMETERS(0.2, 1.6, 90), place_at(0, 3.6, 0.3));
        plan_part(plan, module, "fan", FINISH_PAINT_BLUE, part_fan, PARAMETERS(0.25, 0.2, 24),
                  place_at(1.1, 3.6, -0.4));
        plan_part(plan, module, "ducts", FINISH_GALVANISED, part_duct,
                  PARAMETERS(2.4, 0, 0, 0.4, 0.4), place_at(-1.2, 4.4, 0));
    }
}

static void plan_oven(assembly_plan* plan, uint32_t line, const standard_parts* parts)
{
    uint32_t group = plan_group(plan, line, "station 4: oven", place_at(3, 0, 0));
    for (int i = 0; i < 10; ++i) {
        uint32_t module = plan_group(plan, group, plan_text(plan, "oven section %d", i + 1),
                                     place_at(-9 + 2.0 * i, 0, 0));
        plan_place(plan, module, "shell", parts->oven_shell, stp_affine_identity());
        plan_place(plan, module, "nozzles", parts->oven_nozzles, stp_affine_identity());
        plan_place(plan, module, "burners", parts->oven_burner, stp_affine_identity());
        plan_place(plan, module, "belt", parts->mesh_belt, stp_affine_identity());
        plan_part(plan, module, "circulation fan", FINISH_PAINT_GREY, part_fan,
                  PARAMETERS(0.28, 0.3, 32), place_at(0.3, 1.9, -0.4));
        plan_part(plan, module, "gas train", FINISH_PAINT_YELLOW, part_pipe_run,
                  PARAMETERS(0.03, 1.9, 0.3, -0.4, 2.6, 0, 3), place_at(-0.95, 0, 0.8));
        plan_part(plan, module, "exhaust", FINISH_STAINLESS, part_duct,
                  PARAMETERS(0.8, 1.5, 0, 0.35, 0.35), place_at(-0.6, 2.1, 0));
    }
    PART("chimney", FINISH_STAINLESS, part_duct, place_at(-9, 3.8, 0), 18, 2.5, 0, 0.6, 0.6);
    for (int i = 0; i < 2; ++i) {
        PART(plan_text(plan, "return belt %d", i + 1), FINISH_STEEL, part_mesh_belt,
             place_at(-5 + 10.0 * i, 0, 0), 10, 1.3, 0.45, 0.012);
    }
    PART("belt drive", FINISH_PAINT_BLUE, part_gearbox, place_at(10.6, 0.2, 0.3), 0.9, 0.7, 0.6);
    PART("belt drive chain", FINISH_STEEL, part_chain, place_at(10.4, 0.5, 0), 1.0, 0.03, 2, 0.15);
    PART("walkway", FINISH_GALVANISED, part_floor, place_at(0, 2.9, -1.5), 20, 2, 0, 0);
    PART("walkway frame", FINISH_STAINLESS, part_frame, place_at(0, 0, -1.6), 20, 2.85, 1.0, 8, 1,
         1, 0.12);
    PART("walkway railings", FINISH_PAINT_YELLOW, part_railings, place_at(0, 2.9, -1.6), 20, 1.2);
}

static void plan_finishing(assembly_plan* plan, uint32_t line, const standard_parts* parts)
{
    uint32_t group = plan_group(plan, line, "station 5: glazing and cooling", place_at(20, 0, 0));
    for (int i = 0; i < 3; ++i) {
        double x = -4 + 1.8 * i;
        uint32_t module =
            plan_group(plan, group, plan_text(plan, "glazer %d", i + 1), place_at(x, 0, 0));
        plan_part(plan, module, "tank", FINISH_STAINLESS, part_tank, PARAMETERS(0.4, 0.8, 6),
                  place_at(0, 0.1, 1.6));
        plan_part(plan, module, "pump", FINISH_STAINLESS, part_pump_skid, PARAMETERS(1.2, 1, 0.06),
                  place_at(0, 0, 2.8));
        plan_part(plan, module, "pipes", FINISH_STAINLESS, part_pipe_run,
                  PARAMETERS(0.025, 1.0, 0.6, -1.4, 1.3, 0, 2), place_at(-0.5, 0, 1.5));
        plan_part(plan, module, "curtain", FINISH_STAINLESS, part_funnel, PARAMETERS(0.8, 0.5, 0.2),
                  place_at(0, 0.1, 0));
        plan_part(plan, module, "belt", FINISH_STEEL, part_mesh_belt,
                  PARAMETERS(1.7, 0.9, 1.0, 0.03), stp_affine_identity());
    }
    PART("spiral belt in", FINISH_PLASTIC_WHITE, part_spiral_belt, place_at(4.6, 0, 0), 1.7, 4, 10,
         0.7);
    PART("spiral drum in", FINISH_STAINLESS, part_spiral_drum, place_at(4.6, 0, 0), 1.25, 4);
    PART("spiral belt out", FINISH_PLASTIC_WHITE, part_spiral_belt, place_at(9.8, 0, 0), 1.7, 4, 10,
         0.7);
    PART("spiral drum out", FINISH_STAINLESS, part_spiral_drum, place_at(9.8, 0, 0), 1.25, 4);
    PART("air coolers", FINISH_ALUMINIUM, part_heat_exchanger, place_by_turn(7.2, 1.0, 3.2, 0), 0.5,
         5, 320);
    PART("spiral fans", FINISH_PAINT_BLUE, part_fan, place_at(7.2, 0, -3.3), 0.6, 0.4, 18);
    group = plan_group(plan, line, "station 6: packing", place_at(40, 0, 0));
    for (int i = 0; i < 6; ++i) {
        double x = -7 + 2.4 * i;
        uint32_t module =
            plan_group(plan, group, plan_text(plan, "packer %d", i + 1), place_at(x, 0, 0));
        plan_part(plan, module, "frame", FINISH_STAINLESS, part_frame,
                  PARAMETERS(2, 2.1, 1.6, 1, 1, 1, 0.08), stp_affine_identity());
        plan_part(plan, module, "picker arms", FINISH_PLASTIC_WHITE, part_lattice_mast,
                  PARAMETERS(1.0, 0.08, 10, 2), place_at(0, 1.1, 0));
        plan_part(plan, module, "picker motors", FINISH_PAINT_GREY, part_motors,
                  PARAMETERS(3, 0.07, 0.4), place_at(0, 2.1, 0));
        plan_part(plan, module, "picker gears", FINISH_CAST_IRON, part_gearbox,
                  PARAMETERS(0.5, 0.3, 0.4), place_at(0.5, 2.1, 0.3));
        plan_part(plan, module, "control", FINISH_PAINT_LIGHT_GREY, part_cabinets, PARAMETERS(2, 2),
                  place_by_turn(0, 0, -2.6, 0));
        plan_part(plan, module, "wiring", FINISH_PLASTIC_BLACK, part_cabinet_wires,
                  PARAMETERS(2, 2), place_by_turn(0, 0, -2.6, 0));
        plan_part(plan, module, "guards", FINISH_PAINT_YELLOW, part_guards, PARAMETERS(2.2, 1.6),
                  place_at(0, 0, 1.3));
        plan_place(plan, module, "belt", parts->belt, place_at(0, 0, 0.45));
    }
}

// Cables, pipes and guards along the whole line, until the number of meshes is reached.
static void plan_services(assembly_plan* plan, uint32_t line, size_t until)
{
    uint32_t group = plan_group(plan, line, "services", stp_affine_identity());
    random_stream random = random_begin(480);
    for (int i = 0; plan->mesh_count < until && !plan->failed; ++i) {
        double x = -50 + 100.0 * (i % 40) / 40.0 + random_between(&random, 0, 1.5),
               side = i & 1 ? 3.3 : -3.6;
        double height = 3.9 + 0.35 * (i / 40 % 4), length = random_between(&random, 2.2, 4.5);
        stp_affine place = place_at(x, 0, side + random_between(&random, -0.3, 0.3));
        switch (i % 5) {
        case 0:
            PART(plan_text(plan, "cable tray %03d", i), FINISH_PLASTIC_BLACK, part_cable_tray,
                 place, 2 * length, 0.4, 46 + i % 20, 2, height);
            break;
        case 1:
            PART(plan_text(plan, "media pipes %03d", i), FINISH_STAINLESS, part_pipe_rack, place,
                 2 * length, 0.8, 3 + i % 3, 0.05, height);
            break;
        case 2:
            PART(plan_text(plan, "steam pipe %03d", i), FINISH_INSULATION, part_pipe_run, place,
                 random_between(&random, 0.03, 0.07), length, 0.8, side > 0 ? -1 : 1, height - 1.0,
                 i % 3, 1 + i % 2);
            break;
        case 3:
            PART(plan_text(plan, "drive %03d", i), FINISH_PAINT_BLUE, part_gearbox,
                 place_at(x, 0.1, side * 0.32), 0.5 + 0.01 * (i % 17), 0.35, 0.3);
            break;
        default:
            PART(plan_text(plan, "valve cluster %03d", i), FINISH_STAINLESS, part_valve_station,
                 place_at(x, 0, side * 1.1), 1.6, 3 + i % 3, 0.025);
            break;
        }
    }
}

static size_t objects_shown(const assembly_plan* plan, size_t first)
{
    size_t count = 0;
    for (size_t i = first; i < plan->object_count; ++i) {
        count += plan->objects[i].mesh != STP_NONE;
    }
    return count;
}

// Conveyors, trays and doughnuts: hundreds per line.
static void plan_flow(assembly_plan* plan, uint32_t line, const standard_parts* parts, size_t first)
{
    uint32_t group = plan_group(plan, line, "conveyors", stp_affine_identity());
    for (int i = 0; i < 50; ++i) {
        double x = -50 + 2.0 * i;
        plan_place(plan, group, plan_text(plan, "roller conveyor %d", i + 1), parts->roller,
                   place_at(x, 0, 4.2));
        plan_place(plan, group, plan_text(plan, "drive chain %d", i + 1), parts->chain,
                   place_at(x, 0.55, 4.75));
        plan_place(plan, group, plan_text(plan, "gear motor %d", i + 1), parts->motor,
                   place_at(x + 0.4, 0.5, 4.6));
        plan_place(plan, group, plan_text(plan, "guard door %d", i + 1), parts->guard,
                   place_at(x, 0, -4.3));
        plan_place(plan, group, plan_text(plan, "foot %d", i + 1), parts->post, place_at(x, 0, 0));
        if (i % 2 == 0) {
            plan_place(plan, group, plan_text(plan, "gear box %d", i + 1), parts->gearbox,
                       place_at(x, 0.1, 0.7));
            plan_place(plan, group, plan_text(plan, "tray rack %d", i + 1), parts->rack,
                       place_by_turn(x, 0, -4.9, 0.01 * i));
        }
    }
    uint32_t product = plan_group(plan, line, "product", stp_affine_identity());
    for (int i = 0; !plan->failed; ++i) {
        size_t left = LINE_OBJECTS - objects_shown(plan, first);
        if (left == 0) {
            break;
        }
        double x = i < 140 ? -7 + 0.4 * i : -48 + 0.68 * (i - 140), z = i < 140 ? 0.0 : 4.2;
        double y = i < 140 ? 1.07 + 0.01 * (i & 1) : 0.955;
        plan_place(plan, product, plan_text(plan, "tray %d", i + 1), parts->tray,
                   place_at(x, y, z));
        if (left > 1) {
            plan_place(plan, product, plan_text(plan, "doughnuts %d", i + 1), parts->dough,
                       place_at(x, y + 0.01, z));
        }
        if (left > 2 && x > 12) {
            plan_place(plan, product, plan_text(plan, "glaze %d", i + 1), parts->glaze,
                       place_at(x, y + 0.01, z));
        }
    }
}

static void plan_line(assembly_plan* plan, uint32_t line)
{
    size_t first = plan->object_count;
    standard_parts parts = add_standard_parts(plan);
    plan_mixing(plan, line);
    plan_make_up(plan, line, &parts);
    plan_proofer(plan, line, &parts);
    plan_oven(plan, line, &parts);
    plan_finishing(plan, line, &parts);
    plan_services(plan, line, LINE_MESHES);
    plan_flow(plan, line, &parts, first);
}

static void plan_hall(assembly_plan* plan)
{
    size_t first = plan->object_count;
    uint32_t hall = plan_group(plan, STP_NONE, "hall", stp_affine_identity());
    uint32_t group = plan_group(plan, hall, "building", stp_affine_identity());
    PART("floor", FINISH_CONCRETE, part_slab, place_at(0, 0, 0), 119, 59, 0.3, 40, 20);
    PART("columns and beams", FINISH_PAINT_LIGHT_GREY, part_frame, place_at(0, 0, 0), 116, 9, 56,
         12, 1, 5, 0.4);
    PART("roof trusses", FINISH_PAINT_LIGHT_GREY, part_roof_truss, place_by_turn(0, 9, 0, 0.25), 57,
         117, 24, 1.6);
    PART("roof sheets", FINISH_PAINT_WHITE, part_cladding,
         ((stp_affine){{{1, 0, 0, 0}, {0, 0, 1, 12.2}, {0, -1, 0, 29.5}}}), 119, 59, 0.3, 0.05);
    PART("wall north", FINISH_PAINT_WHITE, part_cladding, place_by_turn(0, 0, 29.6, 0), 119, 11,
         0.25, 0.04);
    PART("wall west", FINISH_PAINT_WHITE, part_cladding, place_by_turn(-59.6, 0, 0, -0.25), 59, 11,
         0.25, 0.04);
    PART("wall east", FINISH_PAINT_WHITE, part_cladding, place_by_turn(59.6, 0, 0, 0.25), 59, 11,
         0.25, 0.04);
    for (int i = 0; i < 6; ++i) {
        double z = -25 + 10.0 * i;
        PART(plan_text(plan, "main cable tray %d", i + 1), FINISH_PLASTIC_BLACK, part_cable_tray,
             place_at(0, 0, z), 112, 0.6, 60, 2, 6.2);
        PART(plan_text(plan, "sprinkler pipes %d", i + 1), FINISH_PAINT_RED, part_pipe_rack,
             place_at(0, 0, z + 1.5), 110, 0.8, 2, 0.07, 7.8);
        PART(plan_text(plan, "air duct %d", i + 1), FINISH_GALVANISED, part_duct,
             place_at(-55, 8.2, z + 3), 108, 0, 0, 0.7, 0.7);
    }
    uint32_t lamp = MESH("lamp", FINISH_LAMP, part_lamps, 1.6, 0.2, 1, 1, 0);
    uint32_t pallet = MESH("pallet of boxes", FINISH_CARDBOARD, part_boxes, 3, 6, 0.38);
    uint32_t rack = MESH("spare tray rack", FINISH_STAINLESS, part_tray_rack, 16, 0.8, 0.7, 1.8);
    uint32_t bowl = MESH("spare bowl", FINISH_STAINLESS, part_mixer_bowl, 0.62, 0.75);
    uint32_t walkway = MESH("marked walkway", FINISH_PAINT_YELLOW, part_slab, 9, 0.1, 0.004, 3, 1);
    size_t made = plan->mesh_count - LINE_MESHES;
    for (size_t i = made; i < HALL_MESHES; ++i) {
        PART(plan_text(plan, "wall fan %zu", i), FINISH_PAINT_GREY, part_fan,
             place_at(-50.0 + 14 * (double)(i - made), 5, 29.0), 0.5, 0.3, 9);
    }
    group = plan_group(plan, hall, "equipment", stp_affine_identity());
    for (int i = 0; !plan->failed && objects_shown(plan, first) < HALL_OBJECTS; ++i) {
        int column = i / 5 % 24;
        double x = -55 + 4.7 * column;
        switch (i % 5) {
        case 0:
        case 1:
            plan_place(plan, group, plan_text(plan, "lamp %d", i), lamp,
                       place_at(x, 8.4, -25 + 10.0 * (column % 6) + 5.0 * (i % 5)));
            break;
        case 2:
            plan_place(plan, group, plan_text(plan, "pallet %d", i), pallet,
                       place_by_turn(x, 0, -28.2, 0.003 * column));
            break;
        case 3:
            plan_place(plan, group, plan_text(plan, "rack %d", i), column % 4 ? rack : bowl,
                       place_by_turn(x + 1.8, column % 4 ? 0 : 0.3, -28.2, 0.01 * column));
            break;
        default:
            plan_place(plan, group, plan_text(plan, "walkway %d", i), walkway,
                       place_at(-50 + 9.2 * (column % 12), 0.004, column < 12 ? -15.0 : 5.0));
            break;
        }
    }
}

void plan_bakery(assembly_plan* plan)
{
    uint32_t line = plan_prototype(plan, "production line");
    plan_line(plan, line);
    plan_hall(plan);
    uint32_t group = plan_group(plan, STP_NONE, "lines", stp_affine_identity());
    for (int i = 0; i < LINES; ++i) {
        plan_use(plan, group, plan_text(plan, "line %d", i + 1), line,
                 place_at(0, 0, -20 + 10.0 * i));
    }
}

void plan_bakery_line(assembly_plan* plan)
{
    plan_line(plan, plan_group(plan, STP_NONE, "production line", stp_affine_identity()));
}

stp_result scene_add_bakery(stp_scene* scene, uint32_t parent, const stp_affine* place,
                            const scene_options* options, uint32_t* object)
{
    assembly_plan plan;
    plan_begin(&plan, scene->context, options->seed);
    plan_bakery(&plan);
    plan_fit(&plan, &bakery_counts, options->scale);
    stp_result result = plan_build(&plan, scene, parent, "bakery", place, object);
    plan_end(&plan);
    return result;
}
