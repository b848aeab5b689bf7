#!/bin/sh
# cvol export: texts and volumes are put into the page; what does not fit is refused. The page here is a stand-in:
# tests/check_web.sh tests the real one.
. "$(dirname "$0")/lib.sh"

make_volume a.raw uint8 20x24x28
make_nrrd a.nrrd a.raw uint8 20 24 28
expect_done cvol compress a.nrrd a.cvol
expect_done cvol compress a.nrrd b.cvol --lossless

# A copy of the command without a page.
mkdir -p alone/web
cp "$CVOL" alone/cvol
expect_failure 1 'run make web' alone/cvol export --html a.cvol -o a.html
[ ! -e a.html ] || fail 'a failure must not leave a file'

version=$(cvol --version)
echo "<meta content=\"$version\"><title><!--cvol:title--></title><p><!--cvol:caption--></p><!--cvol:volumes-->end" \
    >alone/web/viewer.html
expect_done alone/cvol export --html a.cvol -o a.html --title 'T <&"' --caption "it's"
grep -q '<title>T &#60;&#38;&#34;</title><p>it&#39;s</p>' a.html || fail 'texts must have no meaning in HTML'
grep -q "id=\"cvol-file-0\">$(base64 -w 0 a.cvol)</script>" a.html || fail 'the page must have the file'
expect_done alone/cvol export --html a.cvol b.cvol -o ab.html --link '#mode="mip"' --json
grep -q "id=\"cvol-file-1\">$(base64 -w 0 b.cvol)</script>" ab.html || fail 'the page must have the second file'
grep -q '<title>a.cvol</title>' ab.html || fail 'the title must be the first name'
sed -n 's/.*id="cvol-about">\(.*\)<\/script>$/\1/p' ab.html >about.json
expect_equal "$(json_get volumes.1.name <about.json)" b.cvol
expect_equal "$(json_get start <about.json)" '#mode="mip"'

# Names and colours of labels, which the file has.
python3 -c 'import sys; sys.stdout.buffer.write(bytes((x // 8) % 3 for x in range(20 * 24 * 28)))' >l.raw
make_nrrd l.nrrd l.raw uint8 20 24 28
printf '0 Nothing 0 0 0 0\n1 Left 255 0 0 0\n2 Right 0 255 0 0\n' >names.txt
expect_done cvol compress l.nrrd l.cvol --labels yes --label-table names.txt
expect_done alone/cvol export --html l.cvol -o l.html
sed -n 's/.*id="cvol-about">\(.*\)<\/script>$/\1/p' l.html >about.json
expect_equal "$(json_get volumes.0.labels.1.1 <about.json) $(json_get volumes.0.labels.2.2.1 <about.json)" 'Left 1.0'

# Times and channels of a file are one entry, unless one is chosen.
expect_done cvol compress a.nrrd a.nrrd -o run.cvol
expect_done cvol compress a.nrrd a.nrrd -o cell.cvol --as channels --channel-names DAPI,GFP
expect_done alone/cvol export --html run.cvol cell.cvol -o several.html --json
sed -n 's/.*id="cvol-about">\(.*\)<\/script>$/\1/p' several.html >about.json
expect_equal "$(json_get volumes.0.name <about.json) $(json_get volumes.0.time <about.json)" 'run.cvol -1'
expect_equal "$(json_get volumes.0.channel <about.json)" -1
expect_equal "$(json_get volumes.1.name <about.json) $(json_get volumes.1.time <about.json)" 'cell.cvol -1'
expect_equal "$(json_get volumes.1.channel <about.json)" -1
expect_equal "$(json_get files array <about.json)" '["run.cvol","2-cell.cvol"]'
expect_done alone/cvol export --html run.cvol -o third.html --time 1
sed -n 's/.*id="cvol-about">\(.*\)<\/script>$/\1/p' third.html >about.json
expect_equal "$(json_get volumes.0.time <about.json)" 1

# The same input, the same bytes; a file that had the name stays if the command fails.
expect_done alone/cvol export --html a.cvol -o again.html --title 'T <&"' --caption "it's"
expect_same_file a.html again.html
expect_failure 1 'is not a compressed volume' alone/cvol export --html a.nrrd -o again.html
expect_same_file a.html again.html
expect_failure 1 'missing.cvol' alone/cvol export --html missing.cvol -o b.html
expect_failure 2 'give --html' alone/cvol export a.cvol -o b.html
expect_failure 2 'give -o' alone/cvol export --html a.cvol
expect_failure 2 'must end in .html' alone/cvol export --html a.cvol -o b.txt
truncate -s 201M large.cvol
head -c 100 a.cvol | dd of=large.cvol conv=notrunc 2>/dev/null
expect_failure 1 'holds at most 200 MB' alone/cvol export --html large.cvol -o large.html
[ ! -e large.html ] || fail 'a failure must not leave a file'

# A folder for a web server.
expect_failure 1 'run make web' alone/cvol export --site public
[ ! -e public ] || fail 'a failure must not leave a folder'
mkdir alone/web/site
echo "<meta content=\"$version\">" >alone/web/site/index.html
echo 'x = 1;' >alone/web/site/convert.js
expect_done alone/cvol export --site public
expect_same_file alone/web/site/index.html public/index.html
expect_same_file alone/web/site/convert.js public/convert.js
expect_done alone/cvol export --site public --json
: >file
expect_failure 1 'file' alone/cvol export --site file
expect_failure 2 'takes no file' alone/cvol export --site public a.cvol
expect_failure 2 'takes no file' alone/cvol export --site public --html
expect_failure 2 'give a .cvol file' alone/cvol export --html -o b.html

echo '<meta content="cvol 0.0.9">' >alone/web/viewer.html
expect_failure 1 'another version' alone/cvol export --html a.cvol -o b.html
