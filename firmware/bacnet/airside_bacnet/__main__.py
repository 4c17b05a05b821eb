import sys

from airside_bacnet.main import main

sys.exit(main())
