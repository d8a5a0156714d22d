// SPDX-License-Identifier: MIT
#include "lab/scenes/paper.h"

typedef struct named_view {
    const char* name;
    stp_vec3d eye, target;
    double fov;
} named_view;

static stp_result build_alone(stp_scene* scene, const scene_options* options, const char* name,
                              void (*make_plan)(assembly_plan* plan), const plan_counts* counts,
                              const named_view* views, size_t view_count)
{
    assembly_plan plan;
    plan_begin(&plan, scene->context, options->seed);
    make_plan(&plan);
    plan_fit(&plan, counts, options->scale);
    stp_affine still = stp_affine_identity();
    stp_result result = plan_build(&plan, scene, STP_NONE, name, &still, NULL);
    plan_end(&plan);
    for (size_t i = 0; result == STP_OK && i < view_count; ++i) {
        const named_view* view = &views[i];
        result = add_view(scene, view->name, view->eye, view->target, view->fov);
    }
    return result;
}

stp_result scene_make_power_plant(stp_scene* scene, const scene_options* options)
{
    static const plan_counts counts = {283, 283, 11543421, 11543421};
    static const named_view views[] = {
        {"overview", {-120, 85, 150}, {0, 15, 0}, 50},
        {"boiler", {14, 20, 42}, {-20, 30, 0}, 60},
        {"inside boiler house", {-35, 9.8, 16}, {-8, 14, -4}, 75},
        {"turbine hall", {9, 13.5, 10}, {50, 8, -4}, 70},
        {"below the turbines", {12, 2, 4}, {60, 4, -6}, 75},
        {"switchyard", {4, 5, -44}, {45, 5, -68}, 60},
        {"tank farm", {-8, 7, -40}, {-56, 4, -66}, 60},
    };
    return build_alone(scene, options, "power plant", plan_power_plant, &counts, views,
                       sizeof(views) / sizeof(views[0]));
}

stp_result scene_make_twenty_million(stp_scene* scene, const scene_options* options)
{
    static const plan_counts counts = {566, 566, 20000000, 20000000};
    static const named_view views[] = {
        {"overview", {-120, 150, 330}, {0, 25, 0}, 50},
        {"between", {4, 28, 108}, {-4, 22, -40}, 70},
        {"first boiler", {-98, 20, 42}, {-132, 30, 0}, 60},
        {"inside boiler house", {-147, 9.8, 16}, {-120, 14, -4}, 75},
        {"second boiler", {98, 20, -42}, {132, 30, 0}, 60},
    };
    return build_alone(scene, options, "twenty million", plan_twenty_million, &counts, views,
                       sizeof(views) / sizeof(views[0]));
}

stp_result scene_make_bakery_line(stp_scene* scene, const scene_options* options)
{
    static const plan_counts counts = {1400, 480, 53000000, 26500000};
    static const named_view views[] = {
        {"overview", {-30, 14, 26}, {-12, 1, 0}, 60},
        {"mixers", {-36, 3, 5}, {-48, 1.2, -1}, 60},
        {"make-up", {-38, 2.6, 3.4}, {-24, 1, 0}, 60},
        {"oven", {-9.5, 2.0, 2.6}, {6, 1.2, -0.6}, 65},
        {"inside oven", {-5, 1.16, 0.2}, {6, 1.05, 0}, 70},
        {"packing", {31, 2.4, 3.5}, {42, 1, 0}, 65},
    };
    return build_alone(scene, options, "bakery line", plan_bakery_line, &counts, views,
                       sizeof(views) / sizeof(views[0]));
}

stp_result scene_make_car_factory(stp_scene* scene, const scene_options* options)
{
    static const named_view views[] = {
        {"overview", {-142, 9.5, 70}, {-30, 0, -15}, 60},
        {"body shop", {-68, 4.5, -54}, {-20, 1, -61}, 60},
        {"robots", {-44, 2.2, -55}, {-33, 1.2, -60}, 60},
        {"final assembly", {40, 2.6, 8}, {80, 0.8, 14}, 60},
        {"press shop", {-146, 4, -10}, {-112, 3, -40}, 60},
        {"paint shop", {26, 3, -50}, {70, 2, -62}, 60},
    };
    return build_alone(scene, options, "car factory", plan_car_factory, &car_factory_counts, views,
                       sizeof(views) / sizeof(views[0]));
}
