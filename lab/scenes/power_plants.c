// SPDX-License-Identifier: MIT
//
// Sixteen coal-fired power plants. All share 283 meshes, each used once per plant. Each also has
// two of a pool of 21 auxiliary modules: only this way do the numbers of Table 1 fit sixteen equal
// plants.
#include "lab/scenes/paper.h"
#include "lab/scenes/parts.h"
#include "lab/scenes/scene_random.h"

enum { PLANTS = 16, SHARED_MESHES = 283, POOL = 21, POOL_USES = 2 };

const plan_counts power_plants_counts = {4560, 304, 186000000, 12400000};

#define PART(name, finish, maker, place, ...)                                                      \
    plan_part(plan, group, name, finish, maker, PARAMETERS(__VA_ARGS__), place)

static const double plant_pitch = 224, boiler_x = -20, hall_x = 36, filter_x = -56, storey = 7.5;

static void plan_boiler_steel(assembly_plan* plan, uint32_t station)
{
    uint32_t group = plan_group(plan, station, "steelwork", stp_affine_identity());
    PART("main frame", FINISH_PAINT_GREY, part_frame, place_at(0, 0, 0), 36, 60, 36, 4, 8, 4, 0.6);
    for (int i = 1; i <= 8; ++i) {
        uint32_t level =
            plan_group(plan, group, plan_text(plan, "level %d", i), place_at(0, i * storey, 0));
        plan_part(plan, level, "grating", FINISH_GALVANISED, part_floor, PARAMETERS(36, 36, 22, 22),
                  place_at(0, 0.03, 0));
        plan_part(plan, level, "outer railings", FINISH_PAINT_YELLOW, part_railings,
                  PARAMETERS(36, 36), place_at(0, 0, 0));
        plan_part(plan, level, "inner railings", FINISH_PAINT_YELLOW, part_railings,
                  PARAMETERS(21, 21), place_at(0, 0, 0));
    }
    PART("stair tower north", FINISH_GALVANISED, part_stairs, place_at(-14, 0, 20.5), 60, 16);
    PART("stair tower south", FINISH_GALVANISED, part_stairs, place_at(14, 0, -20.5), 60, 16);
    PART("cladding west", FINISH_PAINT_LIGHT_GREY, part_cladding,
         place_by_turn(-18.6, 30, 0, -0.25), 36, 32, 0.25, 0.04);
    PART("cladding south", FINISH_PAINT_LIGHT_GREY, part_cladding,
         place_by_turn(-4, 38, -18.6, 0.5), 26, 24, 0.25, 0.04);
    PART("roof trusses", FINISH_PAINT_GREY, part_roof_truss, place_at(0, 60.3, 0), 36, 36, 6, 2);
}

static void plan_boiler(assembly_plan* plan, uint32_t station)
{
    uint32_t group = plan_group(plan, station, "boiler", stp_affine_identity());
    static const char* const sides[4] = {"front", "right", "rear", "left"};
    for (int i = 0; i < 4; ++i) {
        static const double x[4] = {0, 8, 0, -8}, z[4] = {8, 0, -8, 0};
        PART(plan_text(plan, "water wall %s", sides[i]), FINISH_STEEL, part_tube_wall,
             place_by_turn(x[i], 10, z[i], 0.25 * i + 0.5), 15.6, 42, 0.08);
        PART(plan_text(plan, "burners %s", sides[i]), FINISH_CAST_IRON, part_burners,
             place_by_turn(1.2 * x[i], 15, 1.2 * z[i], 0.25 * i + 0.5), 4, 3, 3.2, 0.55);
        PART(plan_text(plan, "soot blowers %s", sides[i]), FINISH_PAINT_BLUE, part_motors,
             place_by_turn(1.35 * x[i], 37.6, 1.35 * z[i], 0.25 * i), 12, 0.22, 1.1);
    }
    for (int i = 0; i < 6; ++i) {
        PART(plan_text(plan, "superheater %d", i + 1), FINISH_STEEL, part_tube_bank,
             place_at(0, 38, -6.5 + 2.2 * i), 14, 12, 40, 2, 6, 0.025);
    }
    for (int i = 0; i < 3; ++i) {
        PART(plan_text(plan, "economiser %d", i + 1), FINISH_STEEL, part_tube_bank,
             place_at(-13, 12 + 8 * i, -4), 8, 5, 36, 2, 10, 0.02);
    }
    PART("steam drum", FINISH_INSULATION, part_vessel, place_at(0, 53.2, 9), 0.95, 18, 30, 1.6);
    PART("suspension", FINISH_PAINT_GREY, part_box_rows, place_at(0, 52, 0), 15, 15, 14, 14, 0.03,
         8, 0.03);
    for (int i = 0; i < 4; ++i) {
        PART(plan_text(plan, "downcomer %d", i + 1), FINISH_INSULATION, part_pipe_run,
             place_by_turn(i & 1 ? 9.8 : -9.8, 9, i & 2 ? 9.8 : -9.8, 0.25), 0.22, 3, 44, 0, 1, 0,
             1);
        PART(plan_text(plan, "coal mill %d", i + 1), FINISH_CAST_IRON, part_mill,
             place_at(-12 + 8 * i, 0, 14), 1.7, 5);
        PART(plan_text(plan, "coal pipes %d", i + 1), FINISH_PAINT_GREY, part_pipe_run,
             place_by_turn(-12 + 8 * i, 8, 13, 0.25), 0.26, 3.5, 7, 3, 0.5, 0, 1);
        PART(plan_text(plan, "bunker %d", i + 1), FINISH_PAINT_GREY, part_hoppers,
             place_at(-12 + 8 * i, 22, 14.4), 1, 1, 6.5, 7, 2);
    }
}

static void plan_air(assembly_plan* plan, uint32_t station)
{
    uint32_t group = plan_group(plan, station, "air and flue gas", stp_affine_identity());
    for (int i = 0; i < 2; ++i) {
        double z = i ? 8 : -8;
        PART(plan_text(plan, "forced draught fan %d", i + 1), FINISH_PAINT_BLUE, part_fan,
             place_at(9, 0, z), 1.8, 1.6, 24);
        PART(plan_text(plan, "induced draught fan %d", i + 1), FINISH_PAINT_BLUE, part_fan,
             place_at(-50, 0, z), 2.2, 1.9, 28);
        PART(plan_text(plan, "air duct %d", i + 1), FINISH_INSULATION, part_duct,
             place_at(10, 4, z), -6, 12, 0, 2.2, 2.2);
        PART(plan_text(plan, "flue duct %d", i + 1), FINISH_INSULATION, part_duct,
             place_at(-12, 24, z), -14, -6, 0, 3, 3);
        PART(plan_text(plan, "outlet duct %d", i + 1), FINISH_INSULATION, part_duct,
             place_at(-48, 12, z), -14, 0, i ? -7 : 7, 3, 3);
        PART(plan_text(plan, "duct supports %d", i + 1), FINISH_PAINT_GREY, part_frame,
             place_at(-24, 0, z), 6, 18, 5, 1, 3, 1, 0.3);
    }
    group = plan_group(plan, station, "electrostatic precipitator",
                       place_at(filter_x - boiler_x, 0, 0));
    for (int i = 0; i < 3; ++i) {
        PART(plan_text(plan, "collecting plates field %d", i + 1), FINISH_STEEL, part_plates,
             place_at(-6 + 6 * i, 9, 0), 5, 11, 22, 56);
        PART(plan_text(plan, "rapping gear field %d", i + 1), FINISH_PAINT_BLUE, part_motors,
             place_by_turn(-6 + 6 * i, 21, 0, 0.25), 8, 0.2, 2.6);
    }
    PART("casing north", FINISH_PAINT_LIGHT_GREY, part_cladding, place_by_turn(0, 8.6, 11.8, 0), 19,
         12, 0.3, 0.06);
    PART("casing south", FINISH_PAINT_LIGHT_GREY, part_cladding, place_by_turn(0, 8.6, -11.8, 0.5),
         19, 12, 0.3, 0.06);
    PART("roof", FINISH_PAINT_LIGHT_GREY, part_slab, place_at(0, 20.9, 0), 19.4, 24, 0.15, 10, 12);
    PART("ash hoppers", FINISH_PAINT_GREY, part_hoppers, place_at(0, 0, 0), 3, 4, 6, 4.2, 4.4);
    PART("platforms", FINISH_GALVANISED, part_floor, place_at(0, 4.2, 0), 20, 26, 0, 0);
    PART("railings", FINISH_PAINT_YELLOW, part_railings, place_at(0, 21, 0), 19, 24);
    PART("supports", FINISH_PAINT_GREY, part_frame, place_at(0, 0, 0), 19, 8.6, 24, 3, 2, 4, 0.4);
    PART("stairs", FINISH_GALVANISED, part_stairs, place_at(0, 0, 14), 21, 6);
}

static void plan_hall_building(assembly_plan* plan, uint32_t station)
{
    uint32_t group = plan_group(plan, station, "building", stp_affine_identity());
    PART("floor slab", FINISH_CONCRETE, part_slab, place_at(0, 0.05, 0), 62, 34, 0.3, 20, 11);
    PART("columns and beams", FINISH_PAINT_BLUE, part_frame, place_at(0, 0, 0), 60, 20, 32, 10, 2,
         1, 0.7);
    PART("operating floor", FINISH_GALVANISED, part_floor, place_at(0, 8, 0), 60, 30, 42, 9);
    PART("operating floor railings", FINISH_PAINT_YELLOW, part_railings, place_at(0, 8, 0), 42, 9);
    PART("roof trusses", FINISH_PAINT_BLUE, part_roof_truss, place_by_turn(0, 20, 0, 0), 60, 32, 8,
         2.5);
    PART("roof sheets", FINISH_PAINT_LIGHT_GREY, part_cladding,
         ((stp_affine){{{1, 0, 0, 0}, {0, 0, 1, 24.2}, {0, -1, 0, 17}}}), 61, 34, 0.3, 0.05);
    PART("cladding east", FINISH_PAINT_LIGHT_GREY, part_cladding, place_by_turn(30.6, 0, 0, 0.25),
         32, 21, 0.25, 0.04);
    PART("cladding north", FINISH_PAINT_LIGHT_GREY, part_cladding, place_by_turn(0, 9, 16.6, 0), 61,
         12, 0.25, 0.04);
    PART("cladding south", FINISH_PAINT_LIGHT_GREY, part_cladding, place_by_turn(0, 9, -16.6, 0.5),
         61, 12, 0.25, 0.04);
    PART("overhead crane", FINISH_PAINT_YELLOW, part_crane, place_by_turn(-14, 0, 0, 0.25), 30,
         17.5);
    PART("lights", FINISH_LAMP, part_lamps, place_at(0, 19.4, 0), 58, 30, 12, 5, 0);
    PART("stairs west", FINISH_GALVANISED, part_stairs, place_at(-26, 0, 14), 8, 2);
    PART("stairs east", FINISH_GALVANISED, part_stairs, place_at(26, 0, -14), 8, 2);
}

static void plan_turbine(assembly_plan* plan, uint32_t station)
{
    uint32_t group = plan_group(plan, station, "turbine set", place_at(0, 10, 0));
    static const char* const names[4] = {"high pressure", "intermediate pressure", "low pressure 1",
                                         "low pressure 2"};
    static const double x[4] = {-17, -10.5, -2.5, 5.5}, r[4] = {1.0, 1.3, 1.9, 1.9},
                        l[4] = {4, 4.6, 6, 6};
    for (int i = 0; i < 4; ++i) {
        PART(plan_text(plan, "%s rotor", names[i]), FINISH_STEEL, part_turbine_rotor,
             place_at(x[i], 0, 0), r[i], l[i], 18 - 2 * i, 64 + 8 * i);
        PART(plan_text(plan, "%s casing", names[i]), FINISH_PAINT_GREEN, part_turbine_casing,
             place_at(x[i], 0, 0), 1.15 * r[i], l[i]);
    }
    PART("generator", FINISH_PAINT_GREEN, part_generator, place_at(15, 0, 0), 1.8, 8, 72);
    PART("exciter", FINISH_PAINT_GREEN, part_generator, place_at(21.5, 0, 0), 0.8, 2, 48);
    PART("foundation", FINISH_CONCRETE, part_box_rows, place_at(0, -10, 0), 44, 6, 9, 2, 1.4, 7.8,
         1.4);
    PART("condenser 1", FINISH_PAINT_GREY, part_heat_exchanger, place_by_turn(-2.5, -9.5, 0, 0.25),
         2.2, 11, 1200);
    PART("condenser 2", FINISH_PAINT_GREY, part_heat_exchanger, place_by_turn(5.5, -9.5, 0, 0.25),
         2.2, 11, 1200);
    PART("oil tank", FINISH_PAINT_GREEN, part_vessel, place_at(-18, -10, 6), 0.9, 5, 10, 1.4);
    PART("oil coolers", FINISH_PAINT_GREEN, part_heat_exchanger, place_at(-18, -10, 9), 0.5, 4,
         180);
    group = plan_group(plan, station, "feed water", stp_affine_identity());
    for (int i = 0; i < 6; ++i) {
        PART(plan_text(plan, "feed water heater %d", i + 1), FINISH_INSULATION, part_heat_exchanger,
             place_at(-22 + 8.5 * i, i & 1 ? 8.03 : 0.05, 12.5), 0.8, 7, 300);
    }
    for (int i = 0; i < 3; ++i) {
        PART(plan_text(plan, "feed pumps %d", i + 1), FINISH_PAINT_BLUE, part_pump_skid,
             place_at(-16 + 14 * i, 0.05, -8), 10, 3, 0.28);
        PART(plan_text(plan, "valve station %d", i + 1), FINISH_PAINT_RED, part_valve_station,
             place_at(-16 + 14 * i, 0.05, -12), 10, 6, 0.1);
    }
    PART("deaerator", FINISH_INSULATION, part_vessel, place_at(14, 8.03, -11), 1.5, 14, 30, 2.2);
    PART("condensate pumps", FINISH_PAINT_BLUE, part_pump_skid, place_at(18, 0.05, 7.5), 8, 4, 0.2);
    group = plan_group(plan, station, "control", place_at(24, 8.05, 0));
    PART("switchgear", FINISH_PAINT_LIGHT_GREY, part_cabinets, place_by_turn(0, 0, 9, 0.5), 14,
         2.2);
    PART("switchgear wiring", FINISH_COPPER, part_cabinet_wires, place_by_turn(0, 0, 9, 0.5), 14,
         2.2);
    PART("automation", FINISH_PAINT_LIGHT_GREY, part_cabinets, place_by_turn(0, 0, -9, 0), 12, 2.0);
    PART("automation wiring", FINISH_PLASTIC_BLACK, part_cabinet_wires, place_by_turn(0, 0, -9, 0),
         12, 2.0);
    group = plan_group(plan, station, "piping", stp_affine_identity());
    for (int i = 0; i < 5; ++i) {
        PART(plan_text(plan, "pipe tier %d", i + 1), i & 1 ? FINISH_PAINT_GREEN : FINISH_INSULATION,
             part_pipe_rack, place_at(0, 0, -14 + 7 * i), 54, 3.0, 9, 0.16, i & 1 ? 5.4 : 6.4);
    }
    for (int i = 0; i < 5; ++i) {
        PART(plan_text(plan, "cable tray %d", i + 1), FINISH_PLASTIC_BLACK, part_cable_tray,
             place_at(0, 0, -11 + 6 * i), 56, 0.6, 60, 3, i & 1 ? 3.8 : 4.6);
    }
}

static void plan_electric_yard(assembly_plan* plan, uint32_t station)
{
    uint32_t group = plan_group(plan, station, "transformers", place_at(0, 0, 36));
    for (int i = 0; i < 2; ++i) {
        double x = i ? 12 : -12;
        PART(plan_text(plan, "transformer %d", i + 1), FINISH_PAINT_GREY, part_transformer,
             place_at(x, 0, 0), 7, 3.6, 3.2);
        PART(plan_text(plan, "bushings %d", i + 1), FINISH_PORCELAIN, part_insulators,
             place_at(x, 4, 0), 3, 2, 1.8, 1.4, 2.2, 0);
        PART(plan_text(plan, "fire wall %d", i + 1), FINISH_CONCRETE, part_slab,
             place_at(x + 7.5, 6, 0), 0.4, 9, 6, 1, 4);
    }
    group = plan_group(plan, station, "switchyard", stp_affine_identity());
    for (int i = 0; i < 4; ++i) {
        double z = -15 + 10.0 * i;
        PART(plan_text(plan, "gantry %d", i + 1), FINISH_GALVANISED, part_lattice_mast,
             place_at(-24 + 16.0 * i, 0, -12), 20, 1.3, 18, 3);
        PART(plan_text(plan, "post insulators %d", i + 1), FINISH_PORCELAIN, part_insulators,
             place_at(0, 0, z), 9, 3, 5.8, 2.2, 2, 2.4);
        PART(plan_text(plan, "bus bars %d", i + 1), FINISH_ALUMINIUM, part_wires, place_at(0, 0, z),
             52, 4.4, 3, 4.55, 0.05);
        PART(plan_text(plan, "overhead wires %d", i + 1), FINISH_ALUMINIUM, part_wires,
             place_at(-16 + 16.0 * i, 0, -12), 16, 10, 6, 15.5, 1);
        PART(plan_text(plan, "relay cabinets %d", i + 1), FINISH_PAINT_LIGHT_GREY, part_cabinets,
             place_at(-18 + 12 * i, 0, 21), 5, 1.8);
    }
    PART("gravel bed", FINISH_CONCRETE, part_slab, place_at(0, 0.04, 3), 62, 46, 0.2, 12, 9);
    PART("fence", FINISH_GALVANISED, part_fence, place_at(0, 0, 3), 64, 48, 2.4);
}

static void plan_cooling(assembly_plan* plan, uint32_t station)
{
    uint32_t group = plan_group(plan, station, "cooling tower", stp_affine_identity());
    PART("shell", FINISH_CONCRETE, part_cooling_shell, place_at(0, 0, 0), 88, 34, 20);
    PART("legs and basin", FINISH_CONCRETE, part_cooling_legs, place_at(0, 0, 0), 33, 8, 40);
    PART("fill and distribution", FINISH_PLASTIC_WHITE, part_cooling_fill, place_at(0, 0, 0), 30,
         11, 0.9);
    PART("circulating pumps", FINISH_PAINT_BLUE, part_pump_skid, place_at(-40, 0, -12), 14, 4, 0.5);
    PART("circulating pipe north", FINISH_PAINT_GREEN, part_pipe_run,
         place_by_turn(-36, 0, -14, 0.25), 0.8, 30, 0, 14, 2.4, 0, 1);
    PART("circulating pipe south", FINISH_PAINT_GREEN, part_pipe_run,
         place_by_turn(-33, 0, -14, 0.25), 0.8, 32, 0, 14, 4.6, 0, 1);
}

static void plan_coal(assembly_plan* plan, uint32_t station)
{
    uint32_t group = plan_group(plan, station, "coal handling", stp_affine_identity());
    PART("conveyor bridge", FINISH_PAINT_GREY, part_lattice_bridge, place_by_turn(-28, 6, 82, 0.25),
         62, 4, 3.2, 28, 24);
    PART("bridge cladding", FINISH_PAINT_LIGHT_GREY, part_box_rows, place_at(-28, 40, 20), 5, 9, 4,
         6, 0.2, 3.4, 0.2);
    for (int i = 0; i < 3; ++i) {
        PART(plan_text(plan, "yard conveyor %d", i + 1), FINISH_RUBBER, part_belt_conveyor,
             place_at(-62, 0, 52 + 12 * i), 50, 1.2, 1.6);
        PART(plan_text(plan, "bridge mast %d", i + 1), FINISH_PAINT_GREY, part_lattice_mast,
             place_at(-28, 0, 70 - 16 * i), 10 + 7 * i, 2, 8 + 3 * i, 0);
        PART(plan_text(plan, "silo %d", i + 1), FINISH_CONCRETE, part_tank,
             place_at(-84 + 14 * i, 0, 84), 5.5, 22, 8);
    }
    PART("transfer tower", FINISH_PAINT_GREY, part_frame, place_at(-28, 0, 84), 8, 12, 8, 2, 3, 2,
         0.35);
    PART("transfer drive", FINISH_PAINT_BLUE, part_gearbox, place_at(-28, 8.2, 84), 1.8, 1.2, 1.2);
    PART("transfer chain", FINISH_STEEL, part_chain, place_at(-28, 8.6, 82), 6, 0.1, 2, 0.4);
}

static void plan_tank_farm(assembly_plan* plan, uint32_t station)
{
    uint32_t group = plan_group(plan, station, "tank farm", place_at(-52, 0, -62));
    for (int i = 0; i < 6; ++i) {
        PART(plan_text(plan, "tank %d", i + 1), i % 2 ? FINISH_PAINT_WHITE : FINISH_STAINLESS,
             part_tank, place_at(-22 + 22 * (i % 3), 0, i < 3 ? -14 : 10), 6 + i % 3,
             9 + 2 * (i % 2), 14);
    }
    PART("bund", FINISH_CONCRETE, part_slab, place_at(0, 0.04, -2), 68, 52, 0.2, 14, 10);
    PART("bund fence", FINISH_PAINT_YELLOW, part_fence, place_at(0, 0, -2), 70, 54, 1.1);
    PART("tank pumps", FINISH_PAINT_BLUE, part_pump_skid, place_at(-10, 0, 26), 16, 5, 0.2);
    PART("tank manifold", FINISH_PAINT_RED, part_valve_station, place_at(10, 0, 26), 18, 9, 0.12);
    group = plan_group(plan, station, "pipe bridge", place_at(-14, 0, -31));
    PART("bridge frame", FINISH_PAINT_GREY, part_frame, place_at(0, 0, 0), 110, 8, 5, 16, 2, 1,
         0.3);
    for (int i = 0; i < 4; ++i) {
        PART(plan_text(plan, "bridge pipes %d", i + 1),
             i & 1 ? FINISH_INSULATION : FINISH_STAINLESS, part_pipe_rack,
             place_at(-40 + 27 * i, 0, 0), 30, 4.4, 12, 0.15, i & 1 ? 8.0 : 4.0);
        PART(plan_text(plan, "bridge cables %d", i + 1), FINISH_PLASTIC_BLACK, part_cable_tray,
             place_at(-40 + 27 * i, 0, 3.2), 28, 0.8, 90, 2, 6.2);
    }
    PART("long instrument lines", FINISH_STAINLESS, part_wires, place_at(0, 0, -3), 108, 0.8, 24,
         8.3, 0.02);
}

// Fills the plant up with pipes: spools that differ in path, bore and fittings.
static void plan_spools(assembly_plan* plan, uint32_t station, size_t until)
{
    static const plan_finish finishes[] = {FINISH_INSULATION,  FINISH_STAINLESS,
                                           FINISH_PAINT_GREEN, FINISH_PAINT_GREY,
                                           FINISH_PAINT_RED,   FINISH_PAINT_YELLOW};
    uint32_t group = plan_group(plan, station, "piping by isometric", stp_affine_identity());
    random_stream random = random_begin(283);
    for (int i = 1; plan->mesh_count < until && !plan->failed; ++i) {
        double radius = random_between(&random, 0.03, 0.2), length = random_between(&random, 8, 16);
        int level = (int)random_below(&random, 7), side = (int)random_below(&random, 4);
        double rise = (random_unit(&random) < 0.6 ? 1 : 2) * storey,
               out = random_between(&random, 12, 16.5);
        double shift = random_between(&random, -15, 2), branch = random_between(&random, 1, 4);
        stp_affine place = place_by_turn(boiler_x, level * storey + 0.1, 0, 0.25 * side);
        place = stp_affine_multiply(place, place_at(shift, 0, out));
        plan_finish finish = finishes[random_below(&random, 6)];
        double height = random_between(&random, 0.5, 4.5);
        double loops = (double)random_below(&random, 3);
        double valves = (double)(1 + random_below(&random, 3));
        PART(plan_text(plan, "spool %03d", i), finish, part_pipe_run, place, radius, length,
             level < 6 ? rise : -rise, -branch, height, loops, valves);
    }
}

static void plan_common(assembly_plan* plan, uint32_t plant)
{
    size_t until = plan->mesh_count + SHARED_MESHES;
    uint32_t group = plan_group(plan, plant, "site", stp_affine_identity());
    PART("ground", FINISH_ASPHALT, part_slab, place_at(0, 0, 0), 204, 204, 0.4, 34, 34);
    PART("fence", FINISH_GALVANISED, part_fence, place_at(0, 0, 0), 200, 200, 2.4);
    PART("street lights", FINISH_GALVANISED, part_box_rows, place_at(0, 0, 0), 190, 190, 8, 8, 0.14,
         9, 0.14);
    PART("chimney", FINISH_CONCRETE, part_chimney, place_at(-84, 0, 0), 140, 5.5, 3.4);
    PART("control building", FINISH_BRICK, part_slab, place_at(84, 9, -30), 14, 30, 9, 1, 1);
    PART("control building windows", FINISH_GLASS, part_box_rows, place_at(84, 4.5, -30), 14.1, 28,
         5, 12, 2.2, 2.4, 1.8);
    uint32_t station = plan_group(plan, plant, "boiler house", place_at(boiler_x, 0, 0));
    plan_boiler_steel(plan, station);
    plan_boiler(plan, station);
    plan_air(plan, station);
    station = plan_group(plan, plant, "turbine hall", place_at(hall_x, 0, 0));
    plan_hall_building(plan, station);
    plan_turbine(plan, station);
    plan_electric_yard(plan, plan_group(plan, plant, "grid connection", place_at(40, 0, -66)));
    plan_cooling(plan, plan_group(plan, plant, "cooling", place_at(56, 0, 62)));
    plan_coal(plan, plant);
    plan_tank_farm(plan, plant);
    plan_spools(plan, plant, until);
}

static void add_module(assembly_plan* plan, uint32_t meshes[POOL], int i)
{
    const char* name = plan_text(plan, "auxiliary module %02d", i + 1);
    double k = i / 4;
    switch (i % 4) {
    case 0:
        meshes[i] = plan_add_mesh(plan, name, FINISH_PAINT_BLUE, part_pump_skid,
                                  PARAMETERS(8 + k, 2 + 0.4 * k, 0.2 + 0.02 * k));
        break;
    case 1:
        meshes[i] = plan_add_mesh(plan, name, FINISH_PAINT_RED, part_valve_station,
                                  PARAMETERS(9 + k, 2 + 0.5 * k, 0.14));
        break;
    case 2:
        meshes[i] = plan_add_mesh(plan, name, FINISH_STAINLESS, part_heat_exchanger,
                                  PARAMETERS(1.0 + 0.1 * k, 8, 300));
        break;
    default:
        meshes[i] = plan_add_mesh(plan, name, FINISH_PAINT_WHITE, part_tank,
                                  PARAMETERS(3 + 0.3 * k, 6 + k, 16));
        break;
    }
}

void plan_power_plant(assembly_plan* plan)
{
    plan_common(plan, plan_group(plan, STP_NONE, "plant", stp_affine_identity()));
}

// No two parts share a mesh: plan_add_mesh varies each of them.
void plan_twenty_million(assembly_plan* plan)
{
    for (int i = 0; i < 2; ++i) {
        stp_affine place = place_by_turn((i - 0.5) * plant_pitch, 0, 0, 0.5 * i);
        plan_common(plan, plan_group(plan, STP_NONE, plan_text(plan, "plant %d", i + 1), place));
    }
}

void plan_power_plants(assembly_plan* plan)
{
    const double pitch = plant_pitch;
    uint32_t common = plan_prototype(plan, "plant, common part");
    plan_common(plan, common);
    uint32_t pool[POOL];
    for (int i = 0; i < POOL; ++i) {
        add_module(plan, pool, i);
    }
    for (int i = 0; i < PLANTS; ++i) {
        stp_affine place =
            place_by_turn((i % 4 - 1.5) * pitch, 0, (i / 4 - 1.5) * pitch, 0.25 * (i * 7 % 4));
        uint32_t plant = plan_group(plan, STP_NONE, plan_text(plan, "plant %02d", i + 1), place);
        plan_use(plan, plant, "common part", common, stp_affine_identity());
        for (int k = 0; k < POOL_USES; ++k) {
            int module = (i * POOL_USES + k) % POOL;
            plan_place(plan, plant, plan_text(plan, "auxiliary module %02d", module + 1),
                       pool[module], place_by_turn(8 + 16 * k, 0.02, -42, 0.25 * k));
        }
    }
}

stp_result scene_add_power_plants(stp_scene* scene, uint32_t parent, const stp_affine* place,
                                  const scene_options* options, uint32_t* object)
{
    assembly_plan plan;
    plan_begin(&plan, scene->context, options->seed);
    plan_power_plants(&plan);
    plan_fit(&plan, &power_plants_counts, options->scale);
    stp_result result = plan_build(&plan, scene, parent, "power plants", place, object);
    plan_end(&plan);
    return result;
}
