// SPDX-License-Identifier: MIT
//
// A car factory: a press shop, a body shop with welding robots, a paint shop and final assembly.
// Cars are seen in all states: bare sheets in racks, bodies in white, primed, lacquered in three
// colours, and complete.
#include "lab/scenes/paper.h"
#include "lab/scenes/parts.h"
#include "lab/scenes/scene_random.h"

enum { FACTORY_OBJECTS = 1708, FACTORY_MESHES = 179, COLOURS = 4, PANELS = 9, ROBOT_PARTS = 7 };

const plan_counts car_factory_counts = {FACTORY_OBJECTS, FACTORY_MESHES, 75850000, 3970000};

#define PART(name, finish, maker, place, ...)                                                      \
    plan_part(plan, group, name, finish, maker, PARAMETERS(__VA_ARGS__), place)
#define MESH(name, finish, maker, ...)                                                             \
    plan_add_mesh(plan, name, finish, maker, PARAMETERS(__VA_ARGS__))

typedef struct car_parts {
    uint32_t panels[COLOURS][PANELS], glass[3], underbody, wheel, tyre, seats, engine;
    uint32_t robot[ROBOT_PARTS], jig, roller, hanger, pallet, lamp, rack, fence, mark;
} car_parts;

// Extents of panels on the skin: along and around the car.
static const double panel_places[PANELS][5] = {
    {0.05, 0.27, 0.18, 0.82, 60}, // bonnet
    {0.44, 0.70, 0.26, 0.74, 60}, // roof
    {0.86, 0.99, 0.18, 0.82, 44}, // boot lid
    {0.02, 0.30, 0.00, 0.20, 44}, // left wing
    {0.02, 0.30, 0.80, 1.00, 44}, // right wing
    {0.31, 0.52, 0.00, 0.22, 40}, // front left door
    {0.53, 0.72, 0.00, 0.22, 40}, // rear left door
    {0.31, 0.52, 0.78, 1.00, 40}, // front right door
    {0.53, 0.98, 0.78, 1.00, 40}, // right side
};
static const char* const panel_names[PANELS] = {
    "bonnet",          "roof",           "boot lid",         "left wing", "right wing",
    "front left door", "rear left door", "front right door", "right side"};

static void add_car_parts(assembly_plan* plan, car_parts* parts)
{
    static const plan_finish paints[COLOURS] = {FINISH_STEEL, FINISH_CAR_RED, FINISH_CAR_BLUE,
                                                FINISH_CAR_SILVER};
    static const char* const names[COLOURS] = {"bare", "red", "blue", "silver"};
    for (int c = 0; c < COLOURS; ++c) {
        for (int i = 0; i < PANELS; ++i) {
            const double* at = panel_places[i];
            parts->panels[c][i] =
                MESH(plan_text(plan, "%s, %s", panel_names[i], names[c]), paints[c],
                     part_body_panel, at[0], at[1], at[2], at[3], 0.0001, at[4], at[4], 12);
        }
    }
    parts->glass[0] = MESH("windscreen", FINISH_GLASS, part_body_panel, 0.29, 0.435, 0.24, 0.76,
                           0.0001, 40, 40, 1);
    parts->glass[1] = MESH("rear window", FINISH_GLASS, part_body_panel, 0.705, 0.85, 0.25, 0.75,
                           0.0001, 40, 40, 1);
    parts->glass[2] = MESH("side windows", FINISH_GLASS, part_body_panel, 0.36, 0.7, 0.225, 0.255,
                           0.0001, 40, 16, 1);
    parts->underbody = MESH("underbody", FINISH_CAR_PRIMER, part_underbody, 4.2, 1.6, 12);
    parts->wheel = MESH("wheel", FINISH_ALUMINIUM, part_wheel, 0.32, 0.2, 7);
    parts->tyre = MESH("tyre", FINISH_RUBBER, part_tyre, 0.32, 0.21, 110);
    parts->seats = MESH("seats and dashboard", FINISH_UPHOLSTERY, part_seats, 4, 0.75);
    parts->engine = MESH("engine", FINISH_ALUMINIUM, part_engine, 4, 0.085);
    parts->robot[0] = MESH("robot base", FINISH_PAINT_ORANGE, part_robot_base, 0.4, 0.9);
    parts->robot[1] = MESH("robot arm", FINISH_PAINT_ORANGE, part_robot_arm, 1.1, 0.2);
    parts->robot[2] = MESH("robot forearm", FINISH_PAINT_ORANGE, part_robot_arm, 1.2, 0.15);
    parts->robot[3] = MESH("robot wrist", FINISH_STEEL, part_robot_wrist, 0.25, 0.1);
    parts->robot[4] = MESH("weld gun", FINISH_COPPER, part_weld_gun, 0.6);
    parts->robot[5] = MESH("robot hoses", FINISH_PLASTIC_BLACK, part_robot_hoses, 1.3, 1.9, 9);
    parts->robot[6] = MESH("robot plinth", FINISH_PAINT_GREY, part_slab, 1.4, 1.4, 0.3, 1, 1);
    parts->jig = MESH("clamping jig", FINISH_PAINT_BLUE, part_jig, 4.2, 1.5, 16);
    parts->roller =
        MESH("skid conveyor 4 m", FINISH_PAINT_YELLOW, part_roller_conveyor, 4, 1.2, 0.5, 0.4);
    parts->hanger = MESH("overhead chain 6 m", FINISH_STEEL, part_chain, 6, 0.16, 2, 0.2);
    parts->pallet = MESH("parts rack", FINISH_PAINT_GREEN, part_shelf_rack, 8, 5, 1.1, 4);
    parts->lamp = MESH("lamps", FINISH_LAMP, part_lamps, 6, 0.4, 4, 1, 0);
    parts->rack =
        MESH("panel stand", FINISH_PAINT_BLUE, part_box_rows, 1.6, 1.2, 12, 2, 0.03, 1.3, 0.05);
    parts->fence = MESH("safety fence 3 m", FINISH_PAINT_YELLOW, part_fence, 3, 0.02, 2.0);
    parts->mark = MESH("floor marking", FINISH_PAINT_YELLOW, part_slab, 6, 0.12, 0.003, 3, 1);
}

typedef enum car_state { CAR_FRAME, CAR_IN_WHITE, CAR_PAINTED, CAR_COMPLETE } car_state;

static void plan_car(assembly_plan* plan, uint32_t parent, const car_parts* parts, const char* name,
                     car_state state, int colour, stp_affine place)
{
    uint32_t car = plan_group(plan, parent, name, place);
    stp_affine still = stp_affine_identity();
    plan_place(plan, car, "underbody", parts->underbody, still);
    int panels = state == CAR_FRAME ? 2 : PANELS;
    for (int i = 0; i < panels; ++i) {
        plan_place(plan, car, panel_names[i], parts->panels[state < CAR_PAINTED ? 0 : colour][i],
                   still);
    }
    if (state != CAR_COMPLETE) {
        return;
    }
    for (int i = 0; i < 3; ++i) {
        plan_place(plan, car, "glass", parts->glass[i], still);
    }
    plan_place(plan, car, "seats", parts->seats, still);
    plan_place(plan, car, "engine", parts->engine, place_by_turn(-1.55, 0, 0, 0.25));
    for (int i = 0; i < 4; ++i) {
        stp_affine axle =
            place_by_turn(i & 1 ? 1.3 : -1.3, 0.32, i & 2 ? 0.76 : -0.76, i & 2 ? 0 : 0.5);
        plan_place(plan, car, "wheel", parts->wheel, axle);
        plan_place(plan, car, "tyre", parts->tyre, axle);
    }
}

static stp_affine lean(double x, double y, double sine_of_lean)
{
    double d = sine_of_lean, c = sqrt(1.0 - d * d);
    return (stp_affine){{{c, -d, 0, x}, {d, c, 0, y}, {0, 0, 1, 0}}};
}

static void plan_robot(assembly_plan* plan, uint32_t parent, const car_parts* parts,
                       const char* name, random_stream* random, stp_affine place)
{
    uint32_t robot = plan_group(plan, parent, name, place);
    plan_place(plan, robot, "plinth", parts->robot[6], place_at(0, 0.3, 0));
    uint32_t base = plan_group(plan, robot, "axis 1",
                               place_by_turn(0, 0.3, 0, random_between(random, -0.08, 0.08)));
    plan_place(plan, base, "base", parts->robot[0], stp_affine_identity());
    plan_place(plan, base, "hoses", parts->robot[5], stp_affine_identity());
    uint32_t arm =
        plan_group(plan, base, "axis 2", lean(0.1, 0.85, random_between(random, 0.75, 0.98)));
    plan_place(plan, arm, "arm", parts->robot[1], stp_affine_identity());
    uint32_t fore =
        plan_group(plan, arm, "axis 3", lean(1.1, 0, random_between(random, -0.99, -0.9)));
    plan_place(plan, fore, "forearm", parts->robot[2], stp_affine_identity());
    uint32_t wrist =
        plan_group(plan, fore, "axis 5", lean(1.25, 0, random_between(random, -0.6, 0.1)));
    plan_place(plan, wrist, "wrist", parts->robot[3], stp_affine_identity());
    plan_place(plan, wrist, "weld gun", parts->robot[4], place_at(0.3, 0, 0));
}

static void plan_press_shop(assembly_plan* plan, uint32_t factory, const car_parts* parts)
{
    uint32_t shop = plan_group(plan, factory, "press shop", place_at(-112, 0, 0));
    for (int i = 0; i < 6; ++i) {
        uint32_t group = plan_group(plan, shop, plan_text(plan, "press %d", i + 1),
                                    place_at(-20 + 10.0 * (i % 3), 0, i < 3 ? -40 : 20));
        PART("frame", FINISH_PAINT_GREEN, part_press_frame, stp_affine_identity(), 6, 9, 4.5);
        PART("ram and drive", FINISH_STEEL, part_press_drive, stp_affine_identity(), 6, 9, 4.5);
        PART("lower die", FINISH_CAST_IRON, part_die, place_at(0, 1.45, 0), 3, 2, 0.7, 90, 60);
        PART("hydraulics", FINISH_PAINT_BLUE, part_pump_skid, place_by_turn(0, 0, -5, 0), 4, 2,
             0.1);
        PART("control", FINISH_PAINT_LIGHT_GREY, part_cabinets, place_by_turn(0, 0, 6, 0), 5, 2);
        PART("wiring", FINISH_PLASTIC_BLACK, part_cabinet_wires, place_by_turn(0, 0, 6, 0), 5, 2);
        for (int k = 0; k < 4; ++k) {
            plan_place(plan, group, "roller table", parts->roller,
                       place_at(-3.0 + 4.1 * (k % 2), 0.6, k < 2 ? -3.4 : 3.4));
        }
    }
    uint32_t store = plan_group(plan, shop, "panel store", place_at(0, 0, 62));
    for (int i = 0; i < 24; ++i) {
        stp_affine at = place_at(-26 + 4.8 * (i % 12), 0, i < 12 ? 0 : 8);
        plan_place(plan, store, plan_text(plan, "stand %d", i + 1), parts->rack, at);
        plan_place(plan, store, plan_text(plan, "stacked panel %d", i + 1),
                   parts->panels[0][i % PANELS], stp_affine_multiply(at, place_at(0, 0.4, 0)));
    }
}

static void plan_body_shop(assembly_plan* plan, uint32_t factory, const car_parts* parts)
{
    uint32_t shop = plan_group(plan, factory, "body shop", place_at(-24, 0, 0));
    random_stream random = random_begin(7);
    int number = 0;
    for (int line = 0; line < 3; ++line) {
        uint32_t group = plan_group(plan, shop, plan_text(plan, "welding line %d", line + 1),
                                    place_at(0, 0, -60 + 40.0 * line));
        for (int cell = 0; cell < 6; ++cell) {
            double x = -44 + 16.0 * cell;
            uint32_t station =
                plan_group(plan, group, plan_text(plan, "cell %d", cell + 1), place_at(x, 0, 0));
            plan_place(plan, station, "jig", parts->jig, stp_affine_identity());
            plan_car(plan, station, parts, "body", cell < 2 ? CAR_FRAME : CAR_IN_WHITE, 0,
                     place_at(0, 0.55, 0));
            for (int i = 0; i < 4; ++i) {
                double rx = i & 1 ? 1.6 : -1.6, rz = i & 2 ? 2.6 : -2.6;
                plan_robot(plan, station, parts, plan_text(plan, "robot %03d", ++number), &random,
                           place_by_turn(rx, 0, rz, i & 2 ? 0.25 : -0.25));
            }
            for (int i = 0; i < 4; ++i) {
                plan_place(plan, station, "safety fence", parts->fence,
                           place_at(-4.5 + 3.0 * i, 0, 4.8));
            }
            for (int i = 0; i < 3; ++i) {
                plan_place(plan, station, "skid conveyor", parts->roller,
                           place_at(-6 + 4.05 * i, 0, 0));
            }
        }
        PART(plan_text(plan, "line %d control", line + 1), FINISH_PAINT_LIGHT_GREY, part_cabinets,
             place_by_turn(0, 0, 12, 0.5), 7, 2);
        PART(plan_text(plan, "line %d wiring", line + 1), FINISH_COPPER, part_cabinet_wires,
             place_by_turn(0, 0, 12, 0.5), 7, 2);
        PART(plan_text(plan, "line %d frame", line + 1), FINISH_PAINT_LIGHT_GREY, part_frame,
             place_at(0, 0, 0), 96, 6, 8, 12, 1, 1, 0.25);
        PART(plan_text(plan, "line %d cables", line + 1), FINISH_PLASTIC_BLACK, part_cable_tray,
             place_at(0, 0, 3.4), 94, 0.6, 34, 2, 6.3);
        PART(plan_text(plan, "line %d media", line + 1), FINISH_PAINT_BLUE, part_pipe_rack,
             place_at(0, 0, -3.4), 94, 1.6, 3, 0.06, 6.3);
        PART(plan_text(plan, "line %d walkway", line + 1), FINISH_GALVANISED, part_floor,
             place_at(0, 6.3, 0), 94, 2, 0, 0);
        PART(plan_text(plan, "line %d railings", line + 1), FINISH_PAINT_YELLOW, part_railings,
             place_at(0, 6.3, 0), 94, 2);
    }
    uint32_t group = plan_group(plan, shop, "access", stp_affine_identity());
    PART("stairs", FINISH_GALVANISED, part_stairs, place_at(-50, 0, -50), 6.3, 2);
}

static void plan_paint_shop(assembly_plan* plan, uint32_t factory, const car_parts* parts)
{
    uint32_t shop = plan_group(plan, factory, "paint shop", place_at(60, 0, -62));
    uint32_t group = plan_group(plan, shop, "booths", stp_affine_identity());
    for (int i = 0; i < 4; ++i) {
        double x = -24 + 16.0 * i;
        PART(plan_text(plan, "booth %d frame", i + 1), FINISH_STAINLESS, part_frame,
             place_at(x, 0, 0), 14, 5, 7, 6, 1, 1, 0.16);
        PART(plan_text(plan, "booth %d windows", i + 1), FINISH_GLASS, part_box_rows,
             place_at(x, 1.0, 0), 13.6, 7, 10, 2, 1.2, 1.8, 0.01);
        PART(plan_text(plan, "booth %d air", i + 1), FINISH_GALVANISED, part_duct,
             place_at(x - 6, 6, 0), 12, 3, 0, 1.4, 1.4);
        PART(plan_text(plan, "booth %d floor", i + 1), FINISH_GALVANISED, part_floor,
             place_at(x, 0.5, 0), 14, 6, 0, 0);
        PART(plan_text(plan, "booth %d fan", i + 1), FINISH_PAINT_BLUE, part_fan,
             place_at(x + 3, 5.2, 2), 0.9, 0.8, 28);
        PART(plan_text(plan, "paint pumps %d", i + 1), FINISH_STAINLESS, part_pump_skid,
             place_at(x, 0, 7), 5, 4, 0.07);
        plan_car(plan, shop, parts, plan_text(plan, "painted body %d", i + 1), CAR_PAINTED,
                 1 + i % 3, place_at(x, 0.8, 0));
    }
    for (int i = 0; i < 16; ++i) {
        plan_place(plan, shop, plan_text(plan, "overhead chain %d", i + 1), parts->hanger,
                   place_at(-45 + 6.0 * i, 7.2, -12));
    }
}

static void plan_assembly(assembly_plan* plan, uint32_t factory, const car_parts* parts)
{
    uint32_t shop = plan_group(plan, factory, "final assembly", place_at(84, 0, 30));
    for (int line = 0; line < 2; ++line) {
        uint32_t group = plan_group(plan, shop, plan_text(plan, "assembly line %d", line + 1),
                                    place_at(0, 0, -16 + 28.0 * line));
        for (int i = 0; i < 12; ++i) {
            double x = -50 + 8.6 * i;
            plan_car(plan, group, parts, plan_text(plan, "car %d", i + 1),
                     i < 3 ? CAR_PAINTED : CAR_COMPLETE, 1 + (i + line) % 3,
                     place_at(x, i < 6 ? 0.55 : 0.02, 0));
            plan_place(plan, group, "overhead chain", parts->hanger, place_at(x, 5.2, 0));
            plan_place(plan, group, "skid conveyor", parts->roller, place_at(x, 0, 0));
            if (i % 2 == 0) {
                plan_place(plan, group, "parts rack", parts->pallet, place_at(x, 0, 7));
            }
        }
        PART(plan_text(plan, "assembly line %d belt", line + 1), FINISH_RUBBER, part_belt_conveyor,
             place_at(0, 0, 4), 100, 1, 0.5);
        PART(plan_text(plan, "assembly line %d cables", line + 1), FINISH_PLASTIC_BLACK,
             part_cable_tray, place_at(0, 0, 2.4), 104, 0.5, 40, 2, 5.6);
        PART(plan_text(plan, "assembly line %d frame", line + 1), FINISH_PAINT_BLUE, part_frame,
             place_at(0, 0, 0), 104, 5, 5, 13, 1, 1, 0.2);
        PART(plan_text(plan, "assembly line %d crane", line + 1), FINISH_PAINT_YELLOW, part_crane,
             place_by_turn(-30 + 40 * line, 0, 0, 0.25), 14, 8.6);
    }
}

static void plan_factory_hall(assembly_plan* plan, uint32_t factory)
{
    uint32_t group = plan_group(plan, factory, "halls", stp_affine_identity());
    PART("floor", FINISH_CONCRETE, part_slab, place_at(0, 0, 0), 298, 198, 0.3, 60, 40);
    for (int i = 0; i < 3; ++i) {
        static const double x[3] = {-110, -24, 84}, width[3] = {72, 98, 112};
        PART(plan_text(plan, "hall %d columns", i + 1), FINISH_PAINT_GREY, part_frame,
             place_at(x[i], 0, 0), width[i], 12, 192, 4, 1, 12, 0.6);
        PART(plan_text(plan, "hall %d roof trusses", i + 1), FINISH_PAINT_GREY, part_roof_truss,
             place_by_turn(x[i], 12, 0, 0), width[i], 192, 12, 2.5);
        PART(plan_text(plan, "hall %d roof", i + 1), FINISH_PAINT_LIGHT_GREY, part_cladding,
             ((stp_affine){{{1, 0, 0, x[i]}, {0, 0, 1, 16.4}, {0, -1, 0, 97}}}), width[i], 194, 0.5,
             0.06);
        PART(plan_text(plan, "hall %d north wall", i + 1), FINISH_PAINT_LIGHT_GREY, part_cladding,
             place_by_turn(x[i], 0, 97.5, 0), width[i], 14, 1.0, 0.06);
        PART(plan_text(plan, "hall %d air duct", i + 1), FINISH_GALVANISED, part_duct,
             place_by_turn(x[i] + 10, 10.5, 92, 0.25), 180, 0, 0, 1.2, 1.2);
        PART(plan_text(plan, "hall %d sprinklers", i + 1), FINISH_PAINT_RED, part_pipe_rack,
             place_by_turn(x[i] - 10, 0, 0, 0.25), 184, 1.2, 2, 0.08, 10.6);
        PART(plan_text(plan, "hall %d crane", i + 1), FINISH_PAINT_YELLOW, part_crane,
             place_at(x[i], 0, 88), 0.9 * width[i], 10.2);
    }
    PART("west wall", FINISH_PAINT_LIGHT_GREY, part_cladding, place_by_turn(-148.5, 0, 0, -0.25),
         194, 14, 1.0, 0.06);
    PART("east wall", FINISH_PAINT_LIGHT_GREY, part_cladding, place_by_turn(148.5, 0, 0, 0.25), 194,
         14, 0.4, 0.05);
}

static size_t factory_objects(const assembly_plan* plan)
{
    size_t count = 0;
    for (size_t i = 0; i < plan->object_count; ++i) {
        count += plan->objects[i].mesh != STP_NONE;
    }
    return count;
}

// First unique machines, until all meshes exist; then repeated parts.
static void plan_rest(assembly_plan* plan, uint32_t factory, const car_parts* parts)
{
    uint32_t group = plan_group(plan, factory, "machine shop", place_at(84, 0, 76));
    for (int i = 0; plan->mesh_count < FACTORY_MESHES && !plan->failed; ++i) {
        stp_affine at = place_at(-52 + 7.0 * (i % 16), 0, -4 + 8.0 * (i / 16));
        switch (i % 4) {
        case 0:
            PART(plan_text(plan, "machine %d gears", i + 1), FINISH_PAINT_GREEN, part_gearbox, at,
                 2.2, 1.4, 1.2);
            break;
        case 1:
            PART(plan_text(plan, "coolant %d", i + 1), FINISH_PAINT_BLUE, part_pump_skid, at, 3, 2,
                 0.08);
            break;
        case 2:
            PART(plan_text(plan, "tank %d", i + 1), FINISH_STAINLESS, part_tank, at, 1.1, 2.6, 8);
            break;
        default:
            PART(plan_text(plan, "gauge jig %d", i + 1), FINISH_PAINT_ORANGE, part_jig, at, 3, 1.2,
                 12 + i % 5);
            break;
        }
    }
    group = plan_group(plan, factory, "floor and ceiling", stp_affine_identity());
    for (int i = 0; !plan->failed && factory_objects(plan) < FACTORY_OBJECTS; ++i) {
        double x = -140 + 12.0 * (i / 3 % 24), z = -88 + 25.0 * (i / 72 % 8);
        if (i % 3 == 0) {
            plan_place(plan, group, plan_text(plan, "lamps %d", i / 3 + 1), parts->lamp,
                       place_at(x, 11.4, z));
        } else if (i % 3 == 1) {
            plan_place(plan, group, plan_text(plan, "marking %d", i / 3 + 1), parts->mark,
                       place_at(x, 0.003, z + 8));
        } else {
            plan_place(plan, group, plan_text(plan, "rack %d", i / 3 + 1),
                       i % 2 ? parts->pallet : parts->fence,
                       place_at(x, 0, 84.0 - 24.0 * (i / 72 % 2)));
        }
    }
}

void plan_car_factory(assembly_plan* plan)
{
    plan->common_uses = 8.0; // a lacquered panel is on nine cars
    uint32_t factory = plan_group(plan, STP_NONE, "factory", stp_affine_identity());
    car_parts parts;
    add_car_parts(plan, &parts);
    plan_factory_hall(plan, factory);
    plan_press_shop(plan, factory, &parts);
    plan_body_shop(plan, factory, &parts);
    plan_paint_shop(plan, factory, &parts);
    plan_assembly(plan, factory, &parts);
    plan_rest(plan, factory, &parts);
}

stp_result scene_add_car_factory(stp_scene* scene, uint32_t parent, const stp_affine* place,
                                 const scene_options* options, uint32_t* object)
{
    assembly_plan plan;
    plan_begin(&plan, scene->context, options->seed);
    plan_car_factory(&plan);
    plan_fit(&plan, &car_factory_counts, options->scale);
    stp_result result = plan_build(&plan, scene, parent, "car factory", place, object);
    plan_end(&plan);
    return result;
}
