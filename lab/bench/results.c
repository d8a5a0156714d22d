// SPDX-License-Identifier: MIT
#include "lab/bench/results.h"

#include "base/core/processor.h"
#include "program/options/command.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

bench_entry bench_result(json_t* results, const char* name)
{
    json_t* result = json_object();
    bench_entry entry = {json_object(), json_object()};
    json_object_set_new(result, "name", json_string(name));
    json_object_set_new(result, "params", entry.params);
    json_object_set_new(result, "figures", entry.figures);
    json_array_append_new(results, result);
    return entry;
}

void bench_set_count(json_t* object, const char* key, uint64_t value)
{
    json_object_set_new(object, key, json_integer((json_int_t)value));
}

void bench_set_number(json_t* object, const char* key, double value)
{
    json_object_set_new(object, key, json_real(value));
}

void bench_set_text(json_t* object, const char* key, const char* value)
{
    json_object_set_new(object, key, json_string(value));
}

static int compare_doubles(const void* a, const void* b)
{
    double x = *(const double*)a, y = *(const double*)b;
    return (x > y) - (x < y);
}

double bench_median(double* values, size_t count)
{
    if (count == 0) {
        return 0.0;
    }
    qsort(values, count, sizeof(values[0]), compare_doubles);
    return values[(count - 1) / 2];
}

// The name of the CPU, if the system provides it.
static void read_processor_name(char* name, size_t size)
{
    snprintf(name, size, "unknown");
    FILE* file = fopen("/proc/cpuinfo", "r");
    if (file == NULL) {
        return;
    }
    char line[256];
    while (fgets(line, sizeof(line), file) != NULL) {
        char* value = strchr(line, ':');
        if (strncmp(line, "model name", 10) == 0 && value != NULL) {
            value[strcspn(value, "\n")] = 0;
            snprintf(name, size, "%s", value + 1 + strspn(value + 1, " "));
            break;
        }
    }
    fclose(file);
}

static json_t* describe_machine(void)
{
    char name[128];
    read_processor_name(name, sizeof(name));
    json_t* machine = json_object();
    bench_set_text(machine, "processor", name);
    bench_set_count(machine, "threads", (uint64_t)sysconf(_SC_NPROCESSORS_ONLN));
    bench_set_text(machine, "vectors", stp_processor_name(stp_processor_detect()));
    bench_set_text(machine, "compiler", __VERSION__);
    bench_set_text(machine, "version", STP_VERSION);
    return machine;
}

static void print_value(const char* indent, const char* key, const json_t* value)
{
    if (json_is_integer(value)) {
        printf("%s%-34s %14lld\n", indent, key, (long long)json_integer_value(value));
    } else if (json_is_real(value)) {
        printf("%s%-34s %14.6g\n", indent, key, json_real_value(value));
    } else if (json_is_string(value)) {
        printf("%s%-34s %14s\n", indent, key, json_string_value(value));
    }
}

// Lists are only for --json.
static void print_values(const json_t* object, const char* indent)
{
    const char *key, *inner_key;
    json_t *value, *inner;
    json_object_foreach((json_t*)(uintptr_t)object, key, value)
    {
        print_value(indent, key, value);
        json_object_foreach(value, inner_key, inner)
        {
            char name[80];
            snprintf(name, sizeof(name), "%s %s", key, inner_key);
            print_value(indent, name, inner);
        }
    }
}

int bench_print_json(json_t* results)
{
    json_t* object = json_object();
    json_object_set_new(object, "machine", describe_machine());
    json_object_set_new(object, "results", results);
    return tool_print_json(object);
}

int bench_print_text(json_t* results)
{
    json_t* machine = describe_machine();
    print_values(machine, "");
    json_decref(machine);
    size_t index;
    json_t* result;
    json_array_foreach(results, index, result)
    {
        printf("\n%s\n", json_string_value(json_object_get(result, "name")));
        print_values(json_object_get(result, "params"), "  ");
        print_values(json_object_get(result, "figures"), "    ");
    }
    json_decref(results);
    return 0;
}
