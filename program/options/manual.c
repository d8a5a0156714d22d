// SPDX-License-Identifier: MIT
//
// Man pages as mdoc(7), from the tables of the commands.
#include "program/options/options.h"
#include "program/options/program.h"
#include "program/options/tool.h"

#include <assert.h>
#include <ctype.h>
#include <string.h>

// Prints characters so that roff does not treat any as a request.
static void print_escaped(FILE* stream, const char* text, size_t length)
{
    for (size_t i = 0; i < length; ++i) {
        switch (text[i]) {
        case '\\':
            fputs("\\e", stream);
            break;
        case '-':
            fputs("\\-", stream);
            break;
        case '\'':
            fputs("\\(aq", stream);
            break;
        case '`':
            fputs("\\(ga", stream);
            break;
        case '^':
            fputs("\\(ha", stream);
            break;
        case '~':
            fputs("\\(ti", stream);
            break;
        default:
            putc(text[i], stream);
        }
    }
}

// A line that begins with a dot would also be a request.
static void print_line(FILE* stream, const char* text, size_t length)
{
    if (length > 0 && text[0] == '.') {
        fputs("\\&", stream);
    }
    print_escaped(stream, text, length);
    putc('\n', stream);
}

// Each sentence goes on its own line, as roff expects.
static void print_sentences(FILE* stream, const char* text, size_t length)
{
    size_t begin = 0;
    for (size_t i = 0; i + 2 < length; ++i) {
        if (strchr(".!?", text[i]) != NULL && text[i + 1] == ' ' &&
            isupper((unsigned char)text[i + 2])) {
            print_line(stream, text + begin, i + 1 - begin);
            begin = i + 2;
        }
    }
    print_line(stream, text + begin, length - begin);
}

// Paragraphs are separated by empty lines; a line that begins with a space is an example.
static void print_paragraphs(FILE* stream, const char* text)
{
    bool in_example = false, wants_paragraph = false;
    while (text != NULL && *text != 0) {
        size_t length = strcspn(text, "\n");
        bool is_example = *text == ' ';
        if (is_example != in_example) {
            fputs(is_example ? ".Bd -literal -offset indent\n" : ".Ed\n", stream);
            wants_paragraph = !is_example && wants_paragraph;
            in_example = is_example;
        }
        if (length == 0) {
            wants_paragraph = true;
        } else {
            if (wants_paragraph && !is_example) {
                fputs(".Pp\n", stream);
            }
            wants_paragraph = false;
            if (is_example) {
                print_line(stream, text, length);
            } else {
                print_sentences(stream, text, length);
            }
        }
        text += length + (text[length] == '\n');
    }
    if (in_example) {
        fputs(".Ed\n", stream);
    }
}

static void print_quoted(FILE* stream, const char* text)
{
    putc('"', stream);
    for (; *text != 0; ++text) {
        if (*text == '"') {
            fputs("\\(dq", stream);
        } else {
            print_escaped(stream, text, 1);
        }
    }
    putc('"', stream);
}

static void print_option(FILE* stream, const option* o)
{
    fputs(".It ", stream);
    if (o->letter != 0) {
        fprintf(stream, "Fl %c , ", o->letter);
    }
    fputs("Fl \\-", stream);
    print_escaped(stream, o->name, strlen(o->name));
    const char* argument = options_argument(o);
    if (*argument != 0) {
        fputs(" Ar ", stream);
        print_quoted(stream, argument);
    }
    putc('\n', stream);
    print_sentences(stream, o->help, strlen(o->help));
    const char* words = options_hidden_words(o);
    if (words != NULL) {
        fputs("One of\n", stream);
        print_line(stream, words, strlen(words));
    }
}

/// Prints options, each group with its heading.
static void print_options(FILE* stream, const option* table)
{
    const char* heading = NULL;
    for (; table->name != NULL; ++table) {
        if (heading == NULL || (table->group != NULL && strcmp(table->group, heading) != 0)) {
            fputs(heading != NULL ? ".El\n" : "", stream);
            heading = table->group;
            fputs(".Ss ", stream);
            print_line(stream, heading, strlen(heading));
            fputs(".Bl -tag -width Ds\n", stream);
        }
        print_option(stream, table);
    }
    fputs(heading != NULL ? ".El\n" : "", stream);
}

// "2026-11-21" as mdoc writes dates: "November 21, 2026". Other texts stay as they are.
static void print_date(FILE* stream, const char* date)
{
    static const char* const months[] = {"January",   "February", "March",    "April",
                                         "May",       "June",     "July",     "August",
                                         "September", "October",  "November", "December"};
    unsigned year, month, day;
    if (sscanf(date, "%4u-%2u-%2u", &year, &month, &day) == 3 && month >= 1 && month <= 12) {
        fprintf(stream, "%s %u, %u", months[month - 1], day, year);
    } else {
        fputs(date, stream);
    }
}

static void print_upper(FILE* stream, const char* text)
{
    for (; *text != 0; ++text) {
        putc(toupper((unsigned char)*text), stream);
    }
}

static void print_header(FILE* stream, const char* suffix, const char* summary)
{
    const char* name = program_get()->name;
    fputs(".\\\" Made from the tables of options. Do not edit.\n.Dd ", stream);
    print_date(stream, STP_RELEASE_DATE);
    fputs("\n.Dt ", stream);
    print_upper(stream, name);
    print_upper(stream, suffix);
    fprintf(stream, " 1\n.Os stipple %s\n.Sh NAME\n.Nm ", STP_VERSION);
    print_escaped(stream, name, strlen(name));
    print_escaped(stream, suffix, strlen(suffix));
    fputs("\n.Nd ", stream);
    print_line(stream, summary, strlen(summary));
}

// The lines of command.files; mdoc wants this section between ENVIRONMENT and EXIT STATUS.
static void print_files(FILE* stream, const char* text)
{
    fputs(".Sh FILES\n.Bl -tag -width Ds\n", stream);
    while (*text != 0) {
        size_t path = strcspn(text, "\t"), line = strcspn(text, "\n");
        assert(path < line && "PATH<tab>description");
        fputs(".It Pa ", stream);
        print_line(stream, text, path);
        print_line(stream, text + path + 1, line - path - 1);
        text += line + (text[line] == '\n');
    }
    fputs(".El\n", stream);
}

// The lines of command.examples.
static void print_examples(FILE* stream, const char* text)
{
    fputs(".Sh EXAMPLES\n", stream);
    const char* gap = "";
    while (*text != 0) {
        size_t length = strcspn(text, "\n");
        if (*text == '$') {
            fputs(".Dl ", stream);
            print_line(stream, text, length);
        } else {
            fputs(gap, stream);
            print_line(stream, text, length);
        }
        gap = ".Pp\n";
        text += length + (text[length] == '\n');
    }
}

static void print_end(FILE* stream, const char* files, const char* examples)
{
    fputs(".Sh ENVIRONMENT\n.Bl -tag -width Ds\n"
          ".It Ev NO_COLOR\nIf set, messages have no colours.\n"
          ".El\n",
          stream);
    print_files(stream, files);
    fputs(".Sh EXIT STATUS\n.Bl -tag -width Ds\n"
          ".It 0\nSuccess.\n"
          ".It 1\nThe command failed; one sentence on standard error gives the reason.\n"
          ".It 2\nThe command line is invalid.\n"
          ".It 130\nThe command was interrupted.\n"
          ".El\n",
          stream);
    print_examples(stream, examples);
}

static void print_overview(FILE* stream)
{
    print_header(stream, "", "3D scenes of any size as ordered splats");
    fputs(".Sh SYNOPSIS\n.Nm\n.Ar command\n.Op Ar option ...\n.Op Ar argument ...\n"
          ".Sh DESCRIPTION\n"
          ".Nm\nturns 3D scenes into splats, ordered so that every prefix is a picture, stores "
          "them\n"
          "in a file whose prefixes each show the whole scene, and draws it at the frame rate "
          "you ask for.\n"
          "Data goes to standard output, messages and progress go to standard error.\n"
          ".Pp\n"
          "An option takes its value as\n.Fl \\-name Ns = Ns Ar value\nor\n.Fl \\-name Ar value .\n"
          "If an option is repeated, the last one counts.\n"
          "After\n.Fl \\-\neverything is an argument.\n"
          "Sizes such as 512M and 8G are bytes, in powers of 1024.\n"
          ".Pp\nThe commands, each with a separate page:\n"
          ".Bl -tag -width Ds\n",
          stream);
    for (const command* const* c = commands(); *c != NULL; ++c) {
        fputs(".It Cm ", stream);
        print_line(stream, (*c)->name, strlen((*c)->name));
        print_line(stream, (*c)->summary, strlen((*c)->summary));
    }
    fputs(".El\n.Sh OPTIONS\n", stream);
    print_options(stream, options_common());
    print_end(stream,
              "$XDG_CACHE_HOME/stipple\tcache of built models; ~/.cache/stipple if "
              "the variable is not set\n"
              "$XDG_CONFIG_HOME/stipple\tsettings of the viewer; ~/.config/stipple if the "
              "variable is not set\n",
              "Build a model, look at it, draw it:\n"
              "$ stipple build plant.glb -o plant.stip\n"
              "$ stipple view plant.stip\n"
              "$ stipple render plant.stip -o plant.png\n");
    fputs(".Sh SEE ALSO\n", stream);
    for (const command* const* c = commands(); *c != NULL; ++c) {
        fputs(".Xr ", stream);
        print_escaped(stream, program_get()->name, strlen(program_get()->name));
        fputs("\\-", stream);
        print_escaped(stream, (*c)->name, strlen((*c)->name));
        fprintf(stream, " 1%s\n", c[1] != NULL ? " ," : "");
    }
}

void manual_print(FILE* stream, const command* c)
{
    if (c == NULL) {
        print_overview(stream);
        return;
    }
    char suffix[64];
    snprintf(suffix, sizeof(suffix), "-%s", c->name);
    print_header(stream, suffix, c->summary);
    const char* name = program_get()->name;
    fputs(".Sh SYNOPSIS\n.Nm ", stream);
    print_line(stream, name, strlen(name));
    fputs(".Cm ", stream);
    print_line(stream, c->name, strlen(c->name));
    if (*c->arguments != 0) {
        fputs(".Ar ", stream);
        print_quoted(stream, c->arguments);
        putc('\n', stream);
    }
    fputs(".Op Ar option ...\n.Sh DESCRIPTION\n", stream);
    print_paragraphs(stream, c->text != NULL && *c->text != 0 ? c->text : c->summary);
    fputs(".Sh OPTIONS\n", stream);
    print_options(stream, options_of(c));
    print_options(stream, options_common());
    print_end(stream, c->files, c->examples);
    fputs(".Sh SEE ALSO\n.Xr ", stream);
    print_escaped(stream, name, strlen(name));
    fputs(" 1\n", stream);
}
