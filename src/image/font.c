/* A stroke font (font.h), drawn for this purpose.
 *
 * A letter is a list of strokes; a stroke is a list of points, two characters each, x and y
 * upwards, 0 to 9 and A (10) to G (16): the descender ends at 0, letters stand on 4, x is 12 high
 * and capitals reach 16. Strokes are straight from point to point; after ~ they are quadratic
 * B-splines from their first point to their last, after @ closed ones.
 */
#include "image/font.h"

#include <math.h>
#include <string.h>

#define BASE 4
#define CAPITAL 12.0 /* units from there to the top */
#define GAP 3.6      /* between letters */
#define BLANK 5.0
#define WIDTH 1.7 /* of a stroke */
#define MICRO '\x01'
#define DEGREE '\x02'
#define SEGMENTS_MAX 128
#define SEGMENTS 5 /* straight segments of a curved one */

static const struct glyph {
    char letter;
    const char *strokes;
} glyphs[] = {
    {'0', "@04848G0G"},
    {'1', "1C4G44"},
    {'2', "~0D0G8G8C ~8C8A04 0484"},
    {'3', "~0D0G8G8A3A ~3A8A840407"},
    {'4', "6G0787 6G64"},
    {'5', "7G1G1A ~1A8C840407"},
    {'6', "@04848C0C ~7G0G08"},
    {'7', "0G8G34"},
    {'8', "@1A7A7G1G @04848A0A"},
    {'9', "@08888G0G ~8C8414"},
    {'A', "044G84 1777"},
    {'B', "040G ~0G7G7A0A ~0A8A8404"},
    {'C', "~8D8G0G048487"},
    {'D', "040G ~0G8G8404"},
    {'E', "8G0G0484 0A6A"},
    {'F', "8G0G04 0A6A"},
    {'G', "~8D8G0G04848A 8A5A"},
    {'H', "040G 848G 0A8A"},
    {'I', "0G04"},
    {'J', "~6G6A640407"},
    {'K', "040G 8G09 3B84"},
    {'L', "0G0484"},
    {'M', "040G58AGA4"},
    {'N', "040G848G"},
    {'O', "@04949G0G"},
    {'P', "040G ~0G8G8909"},
    {'Q', "@04949G0G 5893"},
    {'R', "040G ~0G8G8909 4984"},
    {'S', "~8D8G0G0A8A840407"},
    {'T', "0G8G 4G44"},
    {'U', "~0G0A04848A8G"},
    {'V', "0G448G"},
    {'W', "0G346C94CG"},
    {'X', "048G 0G84"},
    {'Y', "0G4A8G 4A44"},
    {'Z', "0G8G0484"},
    {'a', "@04747C0C 7C74"},
    {'b', "0G04 @04747C0C"},
    {'c', "~7A7C0C047476"},
    {'d', "@04747C0C 7G74"},
    {'e', "0878 ~787C0C047476"},
    {'f', "~5G2G2C 2C24 0C4C"},
    {'g', "@04747C0C 7C72 ~72700001"},
    {'h', "0G04 ~080C7C78 7874"},
    {'i', "0C04 0G0G"},
    {'j', "2C22 ~222000 2G2G"},
    {'k', "0G04 7C08 2974"},
    {'l', "0G04"},
    {'m', "0C04 ~080C5C58 5854 ~585CACA8 A8A4"},
    {'n', "0C04 ~080C7C78 7874"},
    {'o', "@04747C0C"},
    {'p', "0C00 @04747C0C"},
    {'q', "@04747C0C 7C70"},
    {'r', "0C04 ~080C5C"},
    {'s', "~6A6C0C0868640406"},
    {'t', "2G27 ~272454 0C5C"},
    {'u', "0C08 ~08047478 7C74"},
    {'v', "0C448C"},
    {'w', "0C345B74AC"},
    {'x', "0C74 047C"},
    {'y', "0C44 8C20"},
    {'z', "0C7C0474"},
    {MICRO, "0C00 ~08047478 7C74"},
    {DEGREE, "@0D3D3G0G"},
    {'.', "0404"},
    {',', "1402"},
    {':', "0505 0B0B"},
    {';', "1502 1B1B"},
    {'-', "0959"},
    {'+', "0A6A 3D37"},
    {'=', "0767 0B6B"},
    {'/', "036G"},
    {'\\', "0G63"},
    {'(', "~3G0D0633"},
    {')', "~0G3D3603"},
    {'[', "2G0G0323"},
    {']', "0G2G2303"},
    {'|', "0G03"},
    {'_', "0272"},
    {'*', "3F39 0E6A 0A6E"},
    {'\'', "0G0D"},
    {'"', "0G0D 3G3D"},
    {'%', "048G @0C3C3G0G @54848858"},
    {'^', "0C3G6C"},
    {'<', "6D0A67"},
    {'>', "0D6A07"},
    {'!', "0G08 0404"},
    {'?', "~0D0G7G7B3B38 3434"},
};

static const char *find(char letter)
{
    for (size_t i = 0; i < sizeof glyphs / sizeof *glyphs; i++)
        if (glyphs[i].letter == letter)
            return glyphs[i].strokes;
    return NULL;
}

/* The next letter of a text in UTF-8. */
static char next_letter(const char **text)
{
    const unsigned char *at = (const unsigned char *)*text;
    const int length = at[0] < 0x80 ? 1 : at[0] < 0xe0 ? 2 : at[0] < 0xf0 ? 3 : 4;
    const char letter = length == 1                      ? (char)at[0]
                        : at[0] == 0xc2 && at[1] == 0xb5 ? MICRO
                        : at[0] == 0xce && at[1] == 0xbc ? MICRO
                        : at[0] == 0xc2 && at[1] == 0xb0 ? DEGREE
                                                         : '\x7f';
    for (int i = 0; i < length && **text; i++)
        ++*text;
    return letter;
}

static int number(char c)
{
    return c <= '9' ? c - '0' : c - 'A' + 10;
}

static double advance(const char *strokes)
{
    int widest = 0;
    for (const char *at = strokes; *at; at++) {
        if (strchr("~@ ", *at))
            continue;
        widest = number(*at) > widest ? number(*at) : widest;
        at++;
    }
    return widest + GAP;
}

double cvol_text_width(const char *text, double height)
{
    double units = 0;
    while (*text) {
        const char *strokes = find(next_letter(&text));
        units += strokes ? advance(strokes) : BLANK;
    }
    return (units > 0 ? units - GAP : 0) * height / CAPITAL;
}

/* ---- strokes to segments ------------------------------------------------------------------ */

typedef struct outline {
    cvol_segment segments[SEGMENTS_MAX];
    int count;
    double x, y, unit; /* the letter's place, in pixels */
} outline;

static void add_line(outline *o, const double p[2], const double q[2])
{
    if (o->count == SEGMENTS_MAX)
        return;
    o->segments[o->count++] = (cvol_segment){
        (float)(o->x + p[0] * o->unit), (float)(o->y - (p[1] - BASE) * o->unit),
        (float)(o->x + q[0] * o->unit), (float)(o->y - (q[1] - BASE) * o->unit)};
}

static void add_curve(outline *o, const double a[2], const double b[2], const double c[2])
{
    double before[2] = {a[0], a[1]};
    for (int i = 1; i <= SEGMENTS; i++) {
        const double t = (double)i / SEGMENTS, s = 1 - t;
        const double at[2] = {s * s * a[0] + 2 * s * t * b[0] + t * t * c[0],
                              s * s * a[1] + 2 * s * t * b[1] + t * t * c[1]};
        add_line(o, before, at);
        memcpy(before, at, sizeof before);
    }
}

static void middle(double out[2], const double p[2], const double q[2])
{
    for (int k = 0; k < 2; k++)
        out[k] = (p[k] + q[k]) / 2;
}

static void add_spline(outline *o, const double (*points)[2], int count, int closed)
{
    for (int i = closed ? 0 : 1; i < (closed ? count : count - 1); i++) {
        double from[2], to[2];
        middle(from, points[(i + count - 1) % count], points[i]);
        middle(to, points[i], points[(i + 1) % count]);
        add_curve(o, !closed && i == 1 ? points[0] : from, points[i],
                  !closed && i == count - 2 ? points[count - 1] : to);
    }
}

/* Draws one stroke from `at` on; returns the text after it. */
static const char *add_stroke(outline *o, const char *at)
{
    double points[16][2];
    int count = 0;
    const char kind = *at == '~' || *at == '@' ? *at++ : ' ';
    for (; *at && *at != ' ' && count < 16; at += 2, count++) {
        points[count][0] = number(at[0]);
        points[count][1] = number(at[1]);
    }
    if (kind == ' ')
        for (int i = 1; i < count; i++)
            add_line(o, points[i - 1], points[i]);
    else
        add_spline(o, (const double(*)[2])points, count, kind == '@');
    return *at == ' ' ? at + 1 : at;
}

/* ---- drawing ------------------------------------------------------------------------------ */

cvol_pen cvol_text_pen(const cvol_pen *pen, double height)
{
    cvol_pen own = *pen;
    own.width = (float)fmax(WIDTH * height / CAPITAL, 1.1);
    own.halo = (float)fmax(height / 8, 1);
    return own;
}

typedef void (*draw_fn)(cvol_image *image, const cvol_segment *segments, int count,
                        const cvol_pen *pen);

static void draw(cvol_image *image, const char *text, double x, double y, double height,
                 const cvol_pen *pen, draw_fn with)
{
    outline o = {.x = x, .y = y, .unit = height / CAPITAL};
    while (*text) {
        const char *strokes = find(next_letter(&text));
        o.count = 0;
        for (const char *at = strokes; at && *at;)
            at = add_stroke(&o, at);
        if (o.count)
            with(image, o.segments, o.count, pen);
        o.x += o.unit * (strokes ? advance(strokes) : BLANK);
    }
}

void cvol_text_draw(cvol_image *image, const char *text, double x, double y, double height,
                    const cvol_pen *pen)
{
    const cvol_pen own = cvol_text_pen(pen, height);
    draw(image, text, x, y, height, &own, cvol_ink_halo);
    draw(image, text, x, y, height, &own, cvol_ink_stroke);
}
