// SPDX-License-Identifier: Apache-2.0

import {testIn} from './page_tests.js';

testIn('firefox');
