// SPDX-License-Identifier: MIT
//
// Help as text for a terminal, from the tables of the commands.
#include "program/options/options.h"
#include "program/options/program.h"
#include "program/options/tool.h"

#include <assert.h>
#include <string.h>

enum { WIDTH = 96, TEXT_COLUMN = 30 };

// Prints words of `text`, wrapped, with `indent` spaces before lines after the first; `column` is
// the cursor's position. A line of text that begins with a space is an example and is not wrapped.
static void print_wrapped(FILE* stream, const char* text, int indent, int column)
{
    assert(indent >= 0 && indent < WIDTH && column >= 0);
    while (*text != 0) {
        size_t length = strcspn(text, " \n");
        bool cut = indent + (int)length > WIDTH; // choices that fill more than a line
        if (cut) {
            length = WIDTH - (size_t)indent;
            while (length > 1 && text[length - 1] != '|') {
                length -= 1;
            }
        }
        if (column > indent && column + 1 + (int)length > WIDTH) {
            fprintf(stream, "\n%*s", indent, "");
            column = indent;
        }
        column += fprintf(stream, "%s%.*s", column > indent ? " " : "", (int)length, text);
        text += length;
        column = cut ? WIDTH : column; // the rest begins a line
        text += *text == ' ';
        if (*text == '\n') {
            bool literal = text[1] == '\n' || text[1] == ' ';
            text += 1;
            while (literal && *text == '\n') {
                putc('\n', stream);
                text += 1;
            }
            if (literal) {
                fprintf(stream, "\n%*s", indent, "");
                column = indent;
            }
            if (literal && *text == ' ') {
                length = strcspn(text, "\n");
                fprintf(stream, "%.*s", (int)length, text);
                text += length;
                column = WIDTH;
            }
        }
    }
    putc('\n', stream);
}

static void print_option(FILE* stream, const option* o)
{
    char letter[8] = "    ";
    if (o->letter != 0) {
        snprintf(letter, sizeof(letter), "-%c, ", o->letter);
    }
    const char* argument = options_argument(o);
    int column =
        fprintf(stream, "  %s--%s%s%s", letter, o->name, *argument != 0 ? " " : "", argument);
    if (column > TEXT_COLUMN - 2) {
        putc('\n', stream);
        column = 0;
    }
    fprintf(stream, "%*s", TEXT_COLUMN - column, "");
    char text[1024];
    const char* words = options_hidden_words(o);
    snprintf(text, sizeof(text), "%s%s%s", o->help, words != NULL ? "; one of " : "",
             words != NULL ? words : "");
    print_wrapped(stream, text, TEXT_COLUMN, TEXT_COLUMN);
}

static void print_heading(FILE* stream, const char* text)
{
    bool bold = tool_has_color(stream);
    fprintf(stream, "\n%s%s:%s\n", bold ? "\033[1m" : "", text, bold ? "\033[0m" : "");
}

/// Prints options under their headings. @return the number of rare ones that were left out
static unsigned print_options(FILE* stream, const option* table, bool all)
{
    const char* heading = "";
    unsigned left_out = 0;
    for (; table->name != NULL; ++table) {
        if ((table->rare || table->lab_only) && !all) {
            left_out += 1;
            continue;
        }
        if (table->group != NULL && strcmp(table->group, heading) != 0) {
            heading = table->group;
            print_heading(stream, heading);
        }
        print_option(stream, table);
    }
    return left_out;
}

static unsigned count_options(const option* table)
{
    unsigned count = 0;
    while (table[count].name != NULL) {
        count += 1;
    }
    return count;
}

// "$ command" lines, each after a line that describes it.
static void print_examples(FILE* stream, const char* text)
{
    print_heading(stream, "Examples");
    while (*text != 0) {
        size_t length = strcspn(text, "\n");
        fprintf(stream, "%s%.*s\n", *text == '$' ? "    " : "  ", (int)length, text);
        text += length + (text[length] == '\n');
    }
}

// "PATH<tab>description" lines.
static void print_files(FILE* stream, const char* text)
{
    print_heading(stream, "Files");
    while (*text != 0) {
        size_t path = strcspn(text, "\t"), line = strcspn(text, "\n");
        assert(path < line && "PATH<tab>description");
        char what[512];
        snprintf(what, sizeof(what), "%.*s", (int)(line - path - 1), text + path + 1);
        int column = fprintf(stream, "  %.*s", (int)path, text);
        if (column > TEXT_COLUMN - 2) {
            putc('\n', stream);
            column = 0;
        }
        fprintf(stream, "%*s", TEXT_COLUMN - column, "");
        print_wrapped(stream, what, TEXT_COLUMN, TEXT_COLUMN);
        text += line + (text[line] == '\n');
    }
}

void help_print_overview(FILE* stream)
{
    fprintf(stream,
            "Usage: %s COMMAND [OPTION]... [ARGUMENT]...\n"
            "Stores 3D scenes of any size as splats, ordered so that every prefix is a picture, "
            "and draws them.\n",
            program_get()->name);
    print_heading(stream, "Commands");
    for (const command* const* c = commands(); *c != NULL; ++c) {
        fprintf(stream, "  %-16s%s\n", (*c)->name, (*c)->summary);
    }
    (void)print_options(stream, options_common(), true);
    fprintf(stream, "\nSee '%s help COMMAND' for details.\n", program_get()->name);
}

void help_print_command(FILE* stream, const command* c, bool all)
{
    fprintf(stream, "Usage: %s %s", program_get()->name, c->name);
    fprintf(stream, "%s%s [OPTION]...\n", *c->arguments != 0 ? " " : "", c->arguments);
    print_wrapped(stream, c->summary, 0, 0);
    if (c->text != NULL && *c->text != 0) {
        putc('\n', stream);
        print_wrapped(stream, c->text, 0, 0);
    }
    unsigned left_out = print_options(stream, options_of(c), all);
    if (all) {
        (void)print_options(stream, options_common(), true);
    }
    print_examples(stream, c->examples);
    print_files(stream, c->files);
    if (!all) {
        fprintf(stream, "\n'%s %s --help-all' lists %u more options.\n", program_get()->name,
                c->name, left_out + count_options(options_common()));
    }
}
